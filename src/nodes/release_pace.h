#pragma once

#include <ros/ros.h>

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "nodes/answers.h"
#include "nodes/chain.h"
#include "nodes/graph_connections.h"
#include "nodes/inbox.h"

namespace tactile_clay::nodes {

/// Decides when tracker samples are released. Live, samples of a recording are released at the pace of their
/// stamps times `~rate`, and samples of a tracker as they come. In lockstep, sample k+1 is released when the
/// array has answered sample k. The first sample waits until these are connected: the topics of `~graph` (in
/// the order in which a sample passes them), the latched topics `~recorded_first`, and the node `~recorder`
/// if one is named. Live, the first sample of a recording waits for them with `~wait_for_graph`. Lockstep
/// also waits for a recorder that publishes what it has written (`rig/recorded`): only a few samples may be
/// on their way to its bag. If a sample is not answered within `~answer_patience` s, the run ends with a line
/// that names the node that did not pass it on. `~duration`, s of input, 0: all. For use in one thread.
class ReleasePace {
 public:
  /// @param stopped returns whether every wait has to end
  /// @throws std::runtime_error with one line if a parameter is wrong
  ReleasePace(ros::NodeHandle nh, const ros::NodeHandle& private_nh, Inbox& inbox,
              std::function<bool()> stopped);

  bool lockstep() const { return lockstep_; }

  /// Waits for the connections that the first sample needs.
  /// @throws std::runtime_error with one line if lockstep does not get them in time
  void start(bool recorded);

  /// Waits until the sample of a recording with this stamp is due; in lockstep it does not wait.
  /// @return how long the sample has been due, at least 0; none if `~duration` is over
  std::optional<std::chrono::nanoseconds> due(std::chrono::nanoseconds stamp);

  /// To be called when a live source has sent a sample. Its `~duration` is counted from the first sample,
  /// because a live source may send nothing for any time.
  void sampled();
  bool over() const;

  /// In lockstep, waits until the array has answered.
  /// @param frame its number, for the error line
  /// @throws std::runtime_error with one line if the array does not answer in time
  void awaitAnswer(const ros::Time& stamp, unsigned frame);
  /// Waits for the last sample. In lockstep, until the recorder (if one publishes what it has written) has it
  /// in the bag; it is an error if that does not happen. Live, waits at most 2 s for the array's answer, and
  /// a missing answer is no error.
  void awaitLastAnswer(const ros::Time& stamp);

 private:
  void waitForGraph();
  void awaitRecorder(const ros::Time& stamp);

  ros::NodeHandle nh_;
  std::function<bool()> stopped_;
  double rate_, duration_;  // duration in s
  bool lockstep_;
  ros::WallDuration answer_patience_;  // patience of lockstep, for the graph and for each answer
  bool wait_for_graph_;                // live too; lockstep always waits
  Connections graph_;                  // what must be connected before the first frame
  Answers answers_, recorded_;         // stamps from the array, and from a recorder
  std::deque<ros::Time> unrecorded_;   // samples that may still be on their way to the bag, in lockstep
  ros::Subscriber state_subscriber_, recorded_subscriber_;
  std::optional<Chain> chain_;  // in lockstep
  ros::SteadyTime start_;
  std::optional<std::chrono::nanoseconds> first_stamp_;  // first stamp of a recording
  std::optional<ros::SteadyTime> first_sample_;          // first sample of a live source
};

}  // namespace tactile_clay::nodes
