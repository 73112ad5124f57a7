#pragma once

#include <ros/ros.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "hand/hand_source.h"
#include "nodes/answers.h"
#include "nodes/graph_connections.h"
#include "nodes/health.h"
#include "nodes/plugin.h"
#include "nodes/recording_time.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Reads one source of tracked hands, places them in `world` and publishes `hands/tracked`.
///
/// Live, recordings run by their own clock times `~rate`, and every sample is stamped with the time of its
/// release. In lockstep, stamps are the recording's, and sample k+1 is released when the array has answered
/// sample k; the first one waits until the topics of `~graph`, and the node `~recorder` if one is named, are
/// connected. It ends its process, with code 0, when the source has ended or after `~duration` seconds of
/// input.
class HandTracking {
 public:
  /// \throws std::runtime_error with one line where a parameter is wrong or the source cannot be opened
  HandTracking(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ~HandTracking();

 private:
  using Read = hand::HandSource::Read;

  void run();
  void waitForGraph();
  void follow();
  void pace(std::chrono::nanoseconds elapsed);
  void release(const hand::TrackedFrame& frame);
  bool stopped() const { return stopping_ || !ros::ok(); }
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nh_;
  std::string source_name_;
  std::string world_;
  double rate_, duration_;
  bool lockstep_;
  bool passes_by_ = false;  // the input topic is hands/tracked itself: nothing is to be published

  Plugin<hand::HandSource> source_;
  Transforms transforms_;
  std::shared_ptr<StaticTransforms> static_transforms_ = StaticTransforms::shared();
  Answers answers_;
  ros::Publisher publisher_;
  Connections graph_;    // what must be connected before the first frame
  bool wait_for_graph_;  // live too; lockstep always waits

  RecordingTime time_;
  ros::SteadyTime start_;
  ros::Time last_release_;
  std::atomic<unsigned> frames_{0}, hands_{0}, bad_hands_{0}, repaired_stamps_{0};
  unsigned frames_before_ = 0;

  Health health_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace tactile_clay::nodes
