#include "nodes/skin_queue.h"

#include "nodes/message_check.h"

namespace tactile_clay::nodes {

void SkinQueue::push(const Cloud& skin) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!lockstep_ && !skins_.empty()) ++overtaken_;
    if (!lockstep_ && skins_.size() == max_live) skins_.pop_front();
    requireRoom(skins_.size());
    skins_.push_back(skin);
  }
  came_.notify_all();
}

void SkinQueue::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
  }
  came_.notify_all();
}

bool SkinQueue::wait(Clock::time_point until, std::vector<Cloud>& skins) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto ready = [this] { return stopped_ || !skins_.empty(); };
  if (lockstep_)
    came_.wait(lock, ready);
  else
    came_.wait_until(lock, until, ready);
  skins.clear();
  if (stopped_) return false;
  while (!skins_.empty() && (!lockstep_ || skins.empty())) {
    skins.push_back(skins_.front());
    skins_.pop_front();
  }
  return true;
}

unsigned SkinQueue::overtaken() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return overtaken_;
}

}  // namespace tactile_clay::nodes
