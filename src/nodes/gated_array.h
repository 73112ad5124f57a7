#pragma once

#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/TrackedHands.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device/safety_gate.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// What the nodes of a real and of a simulated array share: `array/focal_points` and `hands/tracked` in, the
/// safety gate, `array/state` out, the services `~stop` and `~reset`, the frame `array`. The array is silent
/// whenever the gate is closed, and in the end. `~modulation` is the one that is going to come: an array that
/// cannot play it says so at once.
class GatedArray {
 public:
  struct Output {
    /// How loud points that are there at once would be, where it can be known.
    device::Meter loudness;
    /// That the array can play, and how many updates a second it takes, 0: any number.
    std::vector<ultrasound::Modulation> modulations;
    double max_rate = 0.0;
    /// Focal points at a time, 0: any number.
    std::size_t max_points = 0;
    /// Emits. \throws std::runtime_error when the array is gone
    std::function<void(const device::Emission&, const std_msgs::Header&)> emit;
    /// Goes silent. The header is that of the frame in force. Must not throw.
    std::function<void(const std_msgs::Header&)> silence;
    /// One line for diagnostics, empty while all is well.
    std::function<std::string()> fault;
  };

  /// \param watch_in_lockstep whether frames may become stale by the wall clock in lockstep too, as for real
  /// arrays \throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  GatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh, const std::string& device,
             bool watch_in_lockstep, Output output);
  ~GatedArray();

 private:
  void receive(const FocalPointArray::ConstPtr& message);
  void refuse(const std::string& reason);
  void seeHands(const TrackedHands::ConstPtr& hands);
  device::Occasion occasion(ros::Time stamp);
  /// Empty, or why the array cannot play it.
  std::string cannotPlay(unsigned modulation) const;
  std::string tooMany(const device::Emission& emission) const;
  void emit(const device::Emission& emission);
  void watch();
  void close(const std::string& reason);
  void publishState(ros::Time stamp);
  bool stop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::string device_;
  bool check_stamps_, watch_, lockstep_;
  device::SafetyGate gate_;
  Output output_;
  std::shared_ptr<StaticTransforms> static_transforms_ = StaticTransforms::shared();

  std_msgs::Header in_force_;    // of the last frame
  ros::SteadyTime last_passed_;  // when the last frame passed the gate
  ros::SteadyTime last_came_;    // when the last frame came
  std::optional<ros::SteadyTime> hands_came_;
  ros::Time hands_stamp_;
  bool hands_tracked_ = false;
  bool emitting_ = false, open_ = false, told_silence_ = false;
  std::string silent_reason_ = "no focal points have come";
  unsigned sent_ = 0, rejected_ = 0, late_ = 0, frames_ = 0;
  double latency_ = 0.0, head_spl_ = 0.0;
  std::string lowered_;            // why the last emission was made weaker
  std::vector<double> latencies_;  // s, since the last diagnostics

  Inbox inbox_;
  ros::Subscriber subscriber_, hands_subscriber_;
  ros::Publisher state_;
  ros::ServiceServer stop_server_, reset_server_;
  ros::WallTimer timer_;
  Health health_;
};

}  // namespace tactile_clay::nodes
