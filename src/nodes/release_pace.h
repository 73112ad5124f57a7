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

/// When samples of hands go on their way. Live, recordings run by their own clock times `~rate`, and trackers
/// as they come. In lockstep, sample k+1 is released when the array has answered sample k; the first one
/// waits until the topics of `~graph` (in the order in which a sample passes them), the latched topics
/// `~recorded_first`, and the node `~recorder` if one is named, are connected; live too with
/// `~wait_for_graph`. A recorder that tells what it has written (`rig/recorded`) is waited for as well: only
/// a few samples may be on their way to its bag. What is not answered within `~answer_patience` s ends the
/// run, with a line that names the node that did not pass it on. `~duration`, s of input, 0: all. Belongs to
/// one thread.
class ReleasePace {
 public:
  /// @param stopped whether every wait is to end
  /// @throws std::runtime_error with one line where a parameter is wrong
  ReleasePace(ros::NodeHandle nh, const ros::NodeHandle& private_nh, Inbox& inbox,
              std::function<bool()> stopped);

  bool lockstep() const { return lockstep_; }

  /// Waits for what has to be there before the first sample.
  /// @throws std::runtime_error with one line where it does not come
  void start(bool recorded);

  /// Waits until the sample of a recording with this stamp is due, in lockstep no time.
  /// @return how long it has been due, at least 0; none where `~duration` is over
  std::optional<std::chrono::nanoseconds> due(std::chrono::nanoseconds stamp);

  /// A live source has sent a sample. It may never send one: its `~duration` runs from the first one on.
  void sampled();
  bool over() const;

  /// In lockstep, waits until the array has answered.
  /// @param frame its number, for people
  /// @throws std::runtime_error with one line where it does not answer in time
  void awaitAnswer(const ros::Time& stamp, unsigned frame);
  /// The same of the last sample, on which only lockstep insists: it may still be on its way. In lockstep it
  /// is in the bag then, too.
  void awaitLastAnswer(const ros::Time& stamp);

 private:
  void waitForGraph();
  void awaitRecorder(const ros::Time& stamp);

  ros::NodeHandle nh_;
  std::function<bool()> stopped_;
  double rate_, duration_;  // s
  bool lockstep_;
  ros::WallDuration answer_patience_;  // of lockstep, for the graph and for each answer
  bool wait_for_graph_;                // live too; lockstep always waits
  Connections graph_;                  // what must be connected before the first frame
  Answers answers_, recorded_;         // of the array, and of a recorder
  std::deque<ros::Time> unrecorded_;   // samples that may still be on their way to the bag, in lockstep
  ros::Subscriber state_subscriber_, recorded_subscriber_;
  std::optional<Chain> chain_;  // in lockstep
  ros::SteadyTime start_;
  std::optional<std::chrono::nanoseconds> first_stamp_;  // of a recording
  std::optional<ros::SteadyTime> first_sample_;          // of a live source
};

}  // namespace tactile_clay::nodes
