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

/// The common part of the nodes of a real and of a simulated array: `array/focal_points` and `hands/tracked`
/// in, the safety gate, `array/state` out, the emergency stop (StopSwitch), and the coordinate frame `array`.
/// It also solves fields, and publishes `array/rendering` for them. The array is silent whenever the gate is
/// closed, while one of `~supervisors` is missing, and when the node ends. `~modulation` is the one that will
/// be asked for: if the array cannot play it, the constructor throws. `~check_stamps`: with true (default)
/// the age of focal points is found from their stamps, with false it is not; with auto it is, unless the
/// stamps are found to be those of a recording. Limits of the gate may be made stricter while the node runs,
/// and may be set back to those of the start (LiveParameters).
class GatedArray {
 public:
  struct Output {
    /// Nobody can be hurt: rules of the gate may be left out.
    bool harmless = false;
    /// Model of the array that the gate judges for, and the functions that solve its drives
    /// (device::Instrument).
    ArrayModel model;
    std::function<ultrasound::PhaseSolution(const std::vector<ultrasound::FocalPoint>&,
                                            const ultrasound::Drive* before)>
        solve;
    device::SolveField solve_field;
    bool scalable = false;
    Repertoire repertoire;
    /// Plays the sound that the gate returned. Has to return at once, because an emergency stop waits for it.
    /// @throws std::runtime_error when the array is gone
    std::function<void(const device::Sound&, const std_msgs::Header&)> emit;
    /// Further work for the same sound, which may take any time; may be empty.
    std::function<void(const device::Sound&, const std_msgs::Header&)> show;
    /// Silences the array. The header is that of the last frame. Must not throw.
    std::function<void(const std_msgs::Header&)> silence;
    /// One line for diagnostics, empty while all is well.
    std::function<std::string()> fault;
  };

  /// @param watch_in_lockstep whether frames may become stale by the wall clock in lockstep too, as for real
  /// arrays
  /// @throws std::runtime_error, std::invalid_argument with one line if a parameter is wrong
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

  // Called by the thread of the emergency stop.
  std::string stop();
  std::string reset();

  // Called by both threads, with the mutex locked. If one returns a line, the caller logs it after it has
  // unlocked the mutex: a log that nobody reads must not delay an emergency stop.
  std::string emit(const device::Sound& sound);
  std::string close(const std::string& why);
  void publishState();

  std::string device_, node_;
  bool watch_, lockstep_;
  Output output_;
  std::shared_ptr<StaticTransforms> static_transforms_ = StaticTransforms::shared();

  // Used by the thread of the callbacks only.
  device::SafetyGateConfig first_limits_;
  std::optional<device::SafetyGate> gate_;
  std::unique_ptr<LiveParameters> live_;
  std::optional<Arrivals> arrivals_;
  std::unique_ptr<Supervisors> supervisors_;  // none in lockstep without a real array
  std::string unsupervised_;                  // line about the missing supervisor
  unsigned heeded_ = 0;                       // number of emergency stops that the gate got
  ros::SteadyTime last_passed_;               // when the last frame passed the gate
  unsigned frames_ = 0;                       // since the last diagnostics
  LatencySpread latencies_;                   // since the last diagnostics
  std::string lowered_;                       // why the last emission was made weaker

  std::atomic<bool> stopped_{false};
  std::atomic<unsigned> stops_{0};  // emergency stops so far

  // Protects emit and silence of `output_`, and the members down to `told_late_`.
  std::mutex mutex_;
  std_msgs::Header in_force_;  // header of the last frame
  ArrayState standing_;        // state as it is published
  bool open_ = false, told_silence_ = false;
  std::string stop_line_;   // line about the last emergency stop, still to be logged
  unsigned told_late_ = 0;  // late frames up to the last diagnostics

  Inbox inbox_;
  ros::Subscriber subscriber_, hands_subscriber_;
  ros::Publisher state_, rendering_;
  ros::WallTimer timer_;
  std::unique_ptr<StopSwitch> stop_switch_;
  Health health_;
};

}  // namespace tactile_clay::nodes
