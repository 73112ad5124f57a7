#include <pluginlib/class_list_macros.hpp>

#include <optional>
#include <stdexcept>

#include "hand/hand_source.h"
#include "nodes/share.h"
#include "scene/score_file.h"

namespace tactile_clay::nodes {

/// Scripted hands, as a tracker would see them.
class ChoreographySource : public hand::HandSource {
 public:
  void open(const hand::SourceOptions& options) override {
    if (options.file.empty())
      throw std::runtime_error(
          "hands of a choreography: expected a score of config/hands, or its file, in 'file'");
    tracker_.emplace(scene::loadScore(options.file, packageFolder()));
    loop_ = options.loop;
    next_ = 0;
    shift_ = std::chrono::nanoseconds(0);
  }

  Read read(hand::TrackedFrame& frame, std::chrono::milliseconds) override {
    if (!tracker_) return Read::ended;
    if (next_ == tracker_->frames()) {
      if (!loop_) return Read::ended;
      shift_ += tracker_->frame(next_ - 1).stamp;
      next_ = 0;
    }
    frame = tracker_->frame(next_++);
    frame.stamp += shift_;
    return Read::frame;
  }

  bool recorded() const override { return true; }

 private:
  std::optional<hand::ScriptedTracker> tracker_;
  bool loop_ = false;
  std::uint64_t next_ = 0;
  std::chrono::nanoseconds shift_{0};
};

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::ChoreographySource, tactile_clay::hand::HandSource)
