#include "nodes/answers.h"

#include <algorithm>
#include <chrono>

#include "nodes/stamps.h"

namespace tactile_clay::nodes {

namespace {

constexpr std::size_t kept = 64;       // answers; more than are on their way at once
constexpr double latest_answer = 1.0;  // s; a message with a later stamp is no answer

}  // namespace

void Answers::add(ros::Time stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  answered_.push_back(stamp);
  if (answered_.size() > kept) answered_.pop_front();
  came_.notify_all();
}

bool Answers::wait(ros::Time stamp, ros::WallDuration patience, const std::function<bool()>& give_up) {
  const ros::WallTime deadline = ros::WallTime::now() + patience;
  const auto answers = [stamp](const ros::Time& answer) {
    const double after = secondsBetween(stamp, answer);
    return after >= 0.0 && after <= latest_answer;
  };
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    if (std::any_of(answered_.begin(), answered_.end(), answers)) return true;
    if (ros::WallTime::now() >= deadline || give_up()) return false;
    came_.wait_for(lock, std::chrono::milliseconds(50));
  }
}

}  // namespace tactile_clay::nodes
