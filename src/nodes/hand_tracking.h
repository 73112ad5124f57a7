#pragma once

#include <ros/ros.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "hand/device_clock.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_source.h"
#include "hand/repeated_hands.h"
#include "nodes/answers.h"
#include "nodes/chain.h"
#include "nodes/graph_connections.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/live_parameters.h"
#include "nodes/plugin.h"
#include "nodes/recording_time.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Settings of the filters. \throws std::runtime_error, std::invalid_argument with one line where one is
/// wrong
hand::CleanConfig cleanConfig(Settings& settings);

/// Reads one source of tracked hands, cleans them (hand_cleaner.h), places them in `world` and publishes
/// `hands/tracked`.
///
/// A live tracker's samples are stamped with the ROS time at which its device took them (device_clock.h);
/// while it says nothing, hands that are there are held and fade out. Live, recordings run by their own clock
/// times `~rate`, and every sample is stamped with the time of its release. In lockstep, stamps are the
/// recording's, and sample k+1 is released when the array has answered sample k; the first one waits until
/// the topics of `~graph` (in the order in which a sample passes them), the latched topics `~recorded_first`,
/// and the node `~recorder` if one is named, are connected. What is not answered within `~answer_patience` s
/// ends the run, with a line that names the node that did not pass it on. It ends its process, with code 0,
/// when the source has ended or after `~duration` seconds of input.
class HandTracking {
 public:
  /// \throws std::runtime_error with one line where a parameter is wrong or the source cannot be opened
  HandTracking(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ~HandTracking();

 private:
  using Read = hand::HandSource::Read;

  void run();
  LiveParameters::Apply read(Settings& settings);
  void waitForClock();
  void tellStandingClock();
  void waitForGraph();
  void follow();
  bool over() const;
  std::optional<std::chrono::nanoseconds> recordingStamp(const hand::TrackedFrame& frame);
  std::chrono::nanoseconds liveStamp(const hand::TrackedFrame& frame);
  void holdHands();
  void releaseHeld();
  bool leaveOutRepeats(hand::TrackedFrame& frame);
  void tellFault();
  void clean(hand::TrackedFrame& frame);
  void pace(std::chrono::nanoseconds elapsed);
  void release(const hand::TrackedFrame& frame);
  bool stopped() const { return stopping_ || !ros::ok(); }
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nh_;
  std::string source_name_;
  std::string world_;
  double rate_, duration_;
  bool lockstep_;
  ros::WallDuration answer_patience_;  // of lockstep, for the graph and for each answer
  bool is_live_ = false;               // the source is no recording
  bool passes_by_ = false;             // the input topic is hands/tracked itself: nothing is to be published

  Plugin<hand::HandSource> source_;
  Transforms transforms_;
  std::shared_ptr<StaticTransforms> static_transforms_ = StaticTransforms::shared();
  Inbox inbox_;
  Answers answers_;
  std::optional<Chain> chain_;  // in lockstep
  ros::Publisher publisher_;
  Connections graph_;    // what must be connected before the first frame
  bool wait_for_graph_;  // live too; lockstep always waits

  RecordingTime time_;
  hand::DeviceClock clock_;
  std::optional<hand::HandCleaner> cleaner_;  // none where hands are passed on as they are
  std::optional<hand::RepeatedHands> repeats_;
  std::optional<std::chrono::nanoseconds> first_stamp_;  // of a recording
  std::optional<ros::SteadyTime> first_sample_;          // of a live source
  std::chrono::nanoseconds last_stamp_{0};               // of what was released
  std::string source_frame_;
  ros::SteadyTime start_;
  ros::Time clock_time_;         // of use_sim_time
  ros::SteadyTime clock_moved_;  // when it was another, or told to stand still
  ros::Time last_release_;

  struct Report {  // of the last second
    unsigned frames = 0;
    double age_sum = 0.0, age_max = 0.0;              // s
    std::array<std::optional<double>, 2> confidence;  // least, by side
    std::string fault;
  };
  std::mutex report_mutex_;
  Report report_;
  hand::CleanCounts counts_;
  ros::WallTime reported_;
  std::atomic<unsigned> frames_{0}, hands_{0}, bad_hands_{0}, bad_fingers_{0}, repeated_hands_{0},
      repaired_stamps_{0}, faults_{0}, clock_restarts_{0};

  std::unique_ptr<LiveParameters> live_;  // the filters, where there are some
  Health health_;
  std::atomic<bool> stopping_{false}, stands_still_{false};
  std::thread thread_;
};

}  // namespace tactile_clay::nodes
