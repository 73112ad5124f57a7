#pragma once

#include <ros/node_handle.h>

#include <memory>

#include "clay/clay.h"
#include "clay/keyframes.h"
#include "nodes/checkpoint.h"

namespace tactile_clay::nodes {

/// Past states of the clay: the states to which `~undo` goes back (`~undo_seconds`, `~undo_megabytes`). Live,
/// and if `keep_running` would start the node again, also a checkpoint every `~checkpoint_seconds`, from
/// which the new node goes on.
class ClayPast {
 public:
  /// @throws std::runtime_error with one line if a parameter is wrong
  ClayPast(const ros::NodeHandle& private_nh, bool lockstep);

  /// If the node was started again in this run, the clay goes on from the checkpoint of the node before it.
  void goOn(clay::Clay& clay);

  /// To be called before each frame.
  void before(const clay::Clay& clay);
  /// To be called after each frame.
  /// @param duration s, simulated
  void after(const clay::Clay& clay, double duration);

  /// Keeps the state that a reset or a load ends.
  void keep(const clay::Sculpture& ended);
  /// To be called when the clay is made with other parameters.
  void parametersChanged() { ++changes_; }

  /// Sets the clay back to an earlier state.
  /// @return s by which the clay went back: `seconds` or more
  /// @throws std::runtime_error with one line if no state is that old
  double undo(double seconds, clay::Clay& clay);

  const clay::Keyframes& states() const { return keyframes_; }

 private:
  clay::Keyframes keyframes_;
  std::string file_;                        // file of the checkpoint; empty: none
  std::unique_ptr<Checkpoint> checkpoint_;  // null before `goOn`, and if there is no checkpoint
  double period_, since_checkpoint_ = 0.0;  // s, simulated
  int changes_ = 0;                         // number of changes of parameters
};

}  // namespace tactile_clay::nodes
