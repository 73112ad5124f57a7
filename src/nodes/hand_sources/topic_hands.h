#pragma once

#include <ros/callback_queue.h>

#include <optional>
#include <string>
#include <utility>

#include "hand/hand_source.h"

namespace tactile_clay::nodes {

/// A source of hands that come as messages. `read` gives the newest of the frames that came.
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
  ros::CallbackQueue queue_;                  // queue of the subscription
  std::optional<hand::TrackedFrame> newest_;  // newest frame, not read yet
  std::string fault_;                         // about a message that was left out
};

}  // namespace tactile_clay::nodes
