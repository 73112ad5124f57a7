#include "nodes/clay_past.h"

#include <ros/console.h>

#include <exception>

#include "clay/sculpture_file.h"
#include "nodes/kept.h"
#include "nodes/params.h"

namespace tactile_clay::nodes {
namespace {

clay::Keyframes::Limits undoLimits(const ros::NodeHandle& nh) {
  constexpr double megabyte = 1024.0 * 1024.0;
  clay::Keyframes::Limits limits;
  limits.seconds = paramIn(nh, "undo_seconds", limits.seconds, 0.0, 3600.0);
  const double maximum =
      paramIn(nh, "undo_megabytes", static_cast<double>(limits.bytes) / megabyte, 1.0, 65536.0);
  limits.bytes = static_cast<std::size_t>(megabyte * maximum);
  return limits;
}

}  // namespace

/// A run in lockstep has no checkpoint: if it lost a node, it could not be repeated to the bit.
ClayPast::ClayPast(const ros::NodeHandle& private_nh, bool lockstep)
    : keyframes_(undoLimits(private_nh)),
      file_(lockstep ? "" : keptFile(private_nh.getNamespace(), ".sculpture")),
      period_(paramIn(private_nh, "checkpoint_seconds", 2.0, 0.0, 3600.0)) {
  if (period_ <= 0.0) file_.clear();
}

void ClayPast::goOn(clay::Clay& clay) {
  if (file_.empty()) return;
  if (isMarked(file_)) {
    try {
      clay.restore(woken(clay::loadSculpture(file_)));
      ROS_WARN("clay_simulator: was started again; the clay continues from its checkpoint at %.2f s",
               clay.time());
    } catch (const std::exception& error) {
      ROS_ERROR("clay_simulator: was started again; the scene starts again, too: %s", error.what());
    }
  }
  checkpoint_ = std::make_unique<Checkpoint>(file_);
}

void ClayPast::before(const clay::Clay& clay) {
  if (keyframes_.pass(0.0)) keyframes_.keep(clay.sculpture(), changes_);  // the state at the start
}

void ClayPast::after(const clay::Clay& clay, double duration) {
  if (keyframes_.pass(duration)) keyframes_.keep(clay.sculpture(), changes_);
  since_checkpoint_ += duration;
  if (checkpoint_ && since_checkpoint_ >= period_) {
    checkpoint_->keep(clay.sculpture());
    since_checkpoint_ = 0.0;
  }
}

void ClayPast::keep(const clay::Sculpture& ended) {
  keyframes_.keep(ended, changes_);
  // The next frame writes a checkpoint, so that the ended clay does not come back.
  since_checkpoint_ = period_;
}

double ClayPast::undo(double seconds, clay::Clay& clay) {
  double went_back = 0.0;
  const clay::Keyframes::State& state = keyframes_.back(seconds, went_back);
  // Sleeping clay may not be in equilibrium with other parameters.
  clay.restore(state.version == changes_ ? state.clay : woken(state.clay));
  since_checkpoint_ = period_;
  return went_back;
}

}  // namespace tactile_clay::nodes
