#include <pluginlib/class_list_macros.hpp>

#include "hand/hand_source.h"

namespace tactile_clay::nodes {

/// 60 frames per second without hands, without end: for a rig without a tracker.
class NoHandsSource : public hand::HandSource {
 public:
  void open(const hand::SourceOptions&) override {}

  Read read(hand::TrackedFrame& frame, std::chrono::milliseconds) override {
    constexpr std::int64_t rate = 60;  // Hz
    frame = {};
    frame.stamp = std::chrono::nanoseconds(++count_ * 1'000'000'000 / rate);
    return Read::frame;
  }

  bool recorded() const override { return true; }

 private:
  std::int64_t count_ = 0;
};

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::NoHandsSource, tactile_clay::hand::HandSource)
