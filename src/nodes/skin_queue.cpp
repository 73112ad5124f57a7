#include "nodes/skin_queue.h"

#include "nodes/message_check.h"

namespace tactile_clay::nodes {

void SkinQueue::push(const Skin& skin) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!lockstep_ && !skins_.empty()) {
      skins_.clear();
      ++overtaken_;
    }
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

bool SkinQueue::wait(Clock::time_point until, Skin& skin) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto ready = [this] { return stopped_ || !skins_.empty(); };
  if (lockstep_)
    came_.wait(lock, ready);
  else
    came_.wait_until(lock, until, ready);
  skin = nullptr;
  if (stopped_) return false;
  if (!skins_.empty()) {
    skin = skins_.front();
    skins_.pop_front();
  }
  return true;
}

unsigned SkinQueue::overtaken() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return overtaken_;
}

}  // namespace tactile_clay::nodes
