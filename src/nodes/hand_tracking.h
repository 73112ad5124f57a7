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

#include "hand/hand_cleaner.h"
#include "hand/hand_source.h"
#include "hand/repeated_hands.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/live_parameters.h"
#include "nodes/placement.h"
#include "nodes/plugin.h"
#include "nodes/release_pace.h"
#include "nodes/sample_clock.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Reads one source of tracked hands, cleans them (hand_cleaner.h), places them in `world` and publishes
/// `hands/tracked`.
///
/// A live tracker's samples are stamped with the ROS time at which its device took them (SampleClock). While
/// the tracker sends nothing, hands that are there are held and fade out. A sample of a recording is stamped
/// with the time at which it was due, or in lockstep with its time in the recording. ReleasePace decides when
/// a sample is released. The node ends its process, with code 0, when the source has ended or after
/// `~duration` seconds of input.
class HandTracking {
 public:
  /// @throws std::runtime_error with one line if a parameter is wrong or the source cannot be opened
  HandTracking(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ~HandTracking();

 private:
  using Read = hand::HandSource::Read;

  void run();
  LiveParameters::Apply read(Settings& settings);
  void follow();
  bool isDue(hand::TrackedFrame& frame);
  void holdHands();
  void releaseHeld();
  bool leaveOutRepeats(hand::TrackedFrame& frame);
  void tellFault();
  void clean(hand::TrackedFrame& frame);
  void release(const hand::TrackedFrame& frame);
  bool stopped() const { return stopping_ || !ros::ok(); }
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::atomic<bool> stopping_{false};
  std::string source_name_;
  std::string world_;
  bool is_live_ = false;    // the source is no recording
  bool passes_by_ = false;  // the input topic is hands/tracked itself: nothing is published

  Plugin<hand::HandSource> source_;
  Transforms transforms_;
  std::shared_ptr<StaticTransforms> static_transforms_ = StaticTransforms::shared();
  Inbox inbox_;
  ReleasePace pace_;
  ros::Publisher publisher_;

  SampleClock clock_;
  std::optional<hand::HandCleaner> cleaner_;  // none if hands are passed on as they are
  std::optional<hand::RepeatedHands> repeats_;
  std::string source_frame_;
  ros::Time last_release_;

  struct Report {  // of the last second
    unsigned frames = 0;
    double age_sum = 0.0, age_max = 0.0;              // s
    std::array<std::optional<double>, 2> confidence;  // minimum, by side
    std::string fault;
  };
  std::mutex report_mutex_;
  Report report_;
  hand::CleanCounts counts_;
  ros::WallTime reported_;
  std::atomic<unsigned> frames_{0}, hands_{0}, bad_hands_{0}, bad_fingers_{0}, repeated_hands_{0}, faults_{0};

  std::unique_ptr<LiveParameters> live_;  // for the filters, if there are any
  Health health_;
  std::atomic<bool> stands_still_{false};
  std::thread thread_;
};

}  // namespace tactile_clay::nodes
