#pragma once

#include <ros/ros.h>
#include <tactile_clay/ArrayState.h>
#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/TrackedHands.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "device/safety_gate.h"
#include "nodes/array_model.h"
#include "nodes/arrivals.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/latency_spread.h"
#include "nodes/live_parameters.h"
#include "nodes/repertoire.h"
#include "nodes/stop_switch.h"
#include "nodes/supervisors.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// What the nodes of a real and of a simulated array share: `array/focal_points` and `hands/tracked` in, the
/// safety gate, `array/state` out (and of fields, which it solves, `array/rendering`), the emergency stop
/// (StopSwitch), the frame `array`. The array is silent whenever the gate is closed, while one of
/// `~supervisors` is missing, and in the end. `~modulation` is the one that is going to come: an array that
/// cannot play it says so at once. `~check_stamps` is true (default), false, or auto: whether the stamps of
/// focal points tell their age, or do so unless they are found to be of a recording. Limits of the gate may
/// be made stricter while it runs, and again as they were at the start (LiveParameters).
class GatedArray {
 public:
  struct Output {
    /// Nobody can be hurt: rules of the gate may be left out.
    bool harmless = false;
    /// The array that the gate judges for, and its drives (device::Instrument).
    ArrayModel model;
    std::function<ultrasound::PhaseSolution(const std::vector<ultrasound::FocalPoint>&,
                                            const ultrasound::Drive* before)>
        solve;
    device::SolveField solve_field;
    bool scalable = false;
    Repertoire repertoire;
    /// Plays what the gate returned, and returns at once: an emergency stop waits for it.
    /// @throws std::runtime_error when the array is gone
    std::function<void(const device::Sound&, const std_msgs::Header&)> emit;
    /// What else is to be done of it, however long it takes; may be empty.
    std::function<void(const device::Sound&, const std_msgs::Header&)> show;
    /// Goes silent. The header is that of the frame in force. Must not throw.
    std::function<void(const std_msgs::Header&)> silence;
    /// One line for diagnostics, empty while all is well.
    std::function<std::string()> fault;
  };

  /// @param watch_in_lockstep whether frames may become stale by the wall clock in lockstep too, as for real
  /// arrays
  /// @throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  GatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh, const std::string& device,
             bool watch_in_lockstep, Output output);
  ~GatedArray();

 private:
  LiveParameters::Apply read(Settings& settings);
  void receive(const FocalPointArray::ConstPtr& message);
  void refuse(const std::string& reason);
  device::Verdict judge(const FocalPointArray& message, const device::StampCheck::Age& age);
  void heedStop();
  void watch();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  // Of the thread of the emergency stop.
  std::string stop();
  std::string reset();

  // Of both threads: the mutex is held. Those that return a line leave it to the caller to log it, without
  // the mutex: a log that nobody reads must not hold up an emergency stop.
  std::string emit(const device::Sound& sound);
  std::string close(const std::string& reason);
  void publishState();

  std::string device_, node_;
  bool watch_, lockstep_;
  Output output_;
  std::shared_ptr<StaticTransforms> static_transforms_ = StaticTransforms::shared();

  // Of the thread of the callbacks.
  device::SafetyGateConfig first_limits_;
  std::optional<device::SafetyGate> gate_;
  std::unique_ptr<LiveParameters> live_;
  std::optional<Arrivals> arrivals_;
  std::unique_ptr<Supervisors> supervisors_;  // none in lockstep without a real array
  std::string unsupervised_;                  // who is missing
  unsigned heeded_ = 0;                       // emergency stops that the gate knows of
  ros::SteadyTime last_passed_;               // when the last frame passed the gate
  unsigned frames_ = 0;                       // since the last diagnostics
  LatencySpread latencies_;                   // since the last diagnostics
  std::string lowered_;                       // why the last emission was made weaker

  std::atomic<bool> stopped_{false};
  std::atomic<unsigned> stops_{0};  // emergency stops so far

  std::mutex mutex_;           // of the array, and of what follows
  std_msgs::Header in_force_;  // of the last frame
  ArrayState standing_;        // as it is published
  bool open_ = false, told_silence_ = false;
  std::string stop_line_;   // of the last emergency stop, to be logged
  unsigned told_late_ = 0;  // of the frames that were late, those that diagnostics told

  Inbox inbox_;
  ros::Subscriber subscriber_, hands_subscriber_, publisher_subscriber_;
  ros::Publisher state_, rendering_;
  ros::WallTimer timer_;
  std::unique_ptr<StopSwitch> stop_switch_;
  Health health_;
};

}  // namespace tactile_clay::nodes
