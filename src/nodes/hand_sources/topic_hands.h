#pragma once

#include <ros/callback_queue.h>

#include <optional>
#include <string>
#include <utility>

#include "hand/hand_source.h"

namespace tactile_clay::nodes {

/// A source of hands that come with messages: of those that came, the newest frame is read.
class TopicHands : public hand::HandSource {
 public:
  Read read(hand::TrackedFrame& frame, std::chrono::milliseconds timeout) override {
    queue_.callAvailable(ros::WallDuration(std::chrono::duration<double>(timeout).count()));
    if (!newest_) return Read::nothing;
    frame = *std::exchange(newest_, std::nullopt);
    return Read::frame;
  }

  bool recorded() const override { return false; }
  std::string takeFault() override { return std::exchange(fault_, {}); }

 protected:
  ros::CallbackQueue queue_;                  // of the subscription
  std::optional<hand::TrackedFrame> newest_;  // not read yet
  std::string fault_;                         // of a message that was left out
};

}  // namespace tactile_clay::nodes
