#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <memory>
#include <string>

#include "hand/hand_source.h"
#include "hand/loop_stamps.h"

namespace tactile_clay::nodes {

/// Tracked hands of a bag file: every message of the topic, in order, with its own coordinate frame and
/// stamp. A message without a stamp gets the time at which it was recorded.
class BagSource : public hand::HandSource {
 public:
  void open(const hand::SourceOptions& options) override;
  Read read(hand::TrackedFrame& frame, std::chrono::milliseconds timeout) override;
  bool recorded() const override { return true; }
  bool cleaned() const override { return true; }

 private:
  std::string file_;
  bool loop_ = false;
  hand::LoopStamps stamps_;
  rosbag::Bag bag_;
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator next_;
};

}  // namespace tactile_clay::nodes
