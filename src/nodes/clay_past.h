#pragma once

#include <ros/node_handle.h>

#include <memory>

#include "clay/clay.h"
#include "clay/keyframes.h"
#include "nodes/checkpoint.h"

namespace tactile_clay::nodes {

/// What the clay was: the states that `~undo` goes back to (`~undo_seconds`, `~undo_megabytes`), and, live
/// and where `keep_running` would start the node again, a checkpoint every `~checkpoint_seconds` to go on
/// from.
class ClayPast {
 public:
  /// @throws std::runtime_error with one line where a parameter is wrong
  ClayPast(const ros::NodeHandle& private_nh, bool lockstep);

  /// Where the node was started again in this run, the clay goes on from the checkpoint of the one before.
  void goOn(clay::Clay& clay);

  /// To be called before each frame.
  void before(const clay::Clay& clay);
  /// To be called after each frame.
  /// @param duration s, simulated
  void after(const clay::Clay& clay, double duration);

  /// Keeps what a reset or a load puts an end to.
  void keep(clay::Sculpture ended);
  /// The clay is made with other parameters from now on.
  void parametersChanged() { ++changes_; }

  /// Puts the clay back to what it was.
  /// @return s, that it went back: `seconds` or more
  /// @throws std::runtime_error with one line where no state is that old
  double undo(double seconds, clay::Clay& clay);

  const clay::Keyframes& states() const { return keyframes_; }

 private:
  clay::Keyframes keyframes_;
  std::string file_;                        // of the checkpoint; empty: none
  std::unique_ptr<Checkpoint> checkpoint_;  // null before `goOn`, and where there is none
  double period_, since_checkpoint_ = 0.0;  // s, simulated
  int changes_ = 0;                         // of parameters that the clay was made with
};

}  // namespace tactile_clay::nodes
