#include "nodes/answers.h"

#include <algorithm>
#include <chrono>

#include "nodes/topics.h"

namespace tactile_clay::nodes {

Answers::Answers(ros::NodeHandle nh) {
  subscriber_ = nh.subscribe<ArrayState>(
      topic::array_state, 0,
      [this](const ArrayState::ConstPtr& state) {
        const std::lock_guard<std::mutex> lock(mutex_);
        newest_ = std::max(newest_, state->header.stamp);
        came_.notify_all();
      },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

bool Answers::wait(ros::Time stamp, ros::WallDuration patience, const std::function<bool()>& give_up) {
  const ros::WallTime deadline = ros::WallTime::now() + patience;
  std::unique_lock<std::mutex> lock(mutex_);
  while (newest_ < stamp && ros::WallTime::now() < deadline && !give_up())
    came_.wait_for(lock, std::chrono::milliseconds(50));
  return newest_ >= stamp;
}

}  // namespace tactile_clay::nodes
