#include "nodes/gated_array.h"

#include <tactile_clay/ArrayState.h>

#include <algorithm>
#include <stdexcept>

#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration watch_period(0.02);

device::SafetyGateConfig gateConfig(const ros::NodeHandle& nh) {
  device::SafetyGateConfig config;
  config.stale_timeout = paramIn(nh, "stale_timeout", config.stale_timeout, 0.001, 10.0);
  config.intensity_cap = paramIn(nh, "intensity_cap", config.intensity_cap, 0.0, 1.0);
  const auto text = [](const Eigen::Vector3d& v) {
    return std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z());
  };
  config.low = pointParam(nh, "workspace_low", text(config.low));
  config.high = pointParam(nh, "workspace_high", text(config.high));
  if (nh.hasParam("head_spl_cap")) config.head_spl_cap = paramIn(nh, "head_spl_cap", 120.0, 0.0, 200.0);
  return config;
}

}  // namespace

GatedArray::GatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh, const std::string& device,
                       bool watch_in_lockstep, Output output)
    : device_(device),
      gate_(gateConfig(private_nh)),
      output_(std::move(output)),
      health_(nh, private_nh, "array", [this](auto& status) { diagnose(status); }) {
  const bool lockstep = param(private_nh, "lockstep", false);
  // Stamps of a recording are of another clock; what is too old is then told by when it arrives.
  check_stamps_ = param(private_nh, "check_stamps", true) && !lockstep;
  watch_ = watch_in_lockstep || !lockstep;
  static_transforms_->send(transformMessage(
      frame::world, frame::array, poseParam(private_nh, "array_pose", "0 0 -0.15 0 0 0"), ros::Time::now()));

  const unsigned queue = lockstep ? 0 : 1;
  stop_server_ = private_nh.advertiseService("stop", &GatedArray::stop, this);
  reset_server_ = private_nh.advertiseService("reset", &GatedArray::reset, this);
  gate_.start();
  subscriber_ = nh.subscribe(topic::focal_points, queue, &GatedArray::receive, this,
                             ros::TransportHints().tcpNoDelay());
  state_ = nh.advertise<ArrayState>(topic::array_state, lockstep ? 0 : 10);
  timer_ = nh.createWallTimer(watch_period, [this](const ros::WallTimerEvent&) { watch(); });
}

GatedArray::~GatedArray() {
  subscriber_.shutdown();
  timer_.stop();
  output_.silence(in_force_);
}

void GatedArray::receive(const FocalPointArray::ConstPtr& message) {
  ++frames_;
  in_force_ = message->header;
  device::Emission emission;
  emission.points = toCore(message->points);
  emission.modulation_frequency = message->modulation_frequency;
  latency_ = check_stamps_ ? (ros::Time::now() - message->header.stamp).toSec() : 0.0;
  latencies_.push_back(latency_);

  std::string reason;
  const device::Verdict in_time = check_stamps_ ? gate_.check({}, latency_) : device::Verdict{};
  if (message->header.frame_id != frame::array) {
    reason = "focal points in frame '" + message->header.frame_id + "', expected '" + frame::array + "'";
  } else if (message->modulation != 0) {
    reason = "modulation " + std::to_string(message->modulation) + " of focal points, expected 0 (AM)";
  } else {
    const auto head_spl = output_.head_spl(emission);
    head_spl_ = head_spl.value_or(0.0);
    reason = gate_.check(emission, latency_, head_spl).reason;
  }
  if (reason.empty()) {
    emit(emission);
  } else {
    ++(in_time.passes() || gate_.stopped() ? rejected_ : late_);
    head_spl_ = 0.0;
    close(reason);
  }
  publishState(in_force_.stamp);
}

void GatedArray::emit(const device::Emission& emission) {
  last_passed_ = ros::SteadyTime::now();
  try {
    output_.emit(emission, in_force_);
    ++sent_;
    open_ = true;
    emitting_ = !emission.points.empty();
    silent_reason_ = emitting_ ? "" : "no focal points";
  } catch (const std::exception& error) {
    ++rejected_;
    close(error.what());
  }
}

void GatedArray::close(const std::string& reason) {
  output_.silence(in_force_);
  if (open_ || frames_ == 1)
    ROS_WARN_THROTTLE(1.0, "array '%s' is silent: %s", device_.c_str(), reason.c_str());
  open_ = emitting_ = false;
  silent_reason_ = reason;
}

void GatedArray::watch() {
  if (!open_) return;
  const double age = watch_ ? (ros::SteadyTime::now() - last_passed_).toSec() : 0.0;
  const device::Verdict verdict = gate_.tick(age);
  if (verdict.passes()) return;
  head_spl_ = 0.0;
  close(verdict.reason);
  publishState(in_force_.stamp);
}

bool GatedArray::stop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  gate_.stop();
  head_spl_ = 0.0;
  close("emergency stop");
  publishState(in_force_.stamp);
  response.success = true;
  response.message = "the array is silent until its service reset is called";
  return true;
}

bool GatedArray::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  gate_.reset();
  if (!open_) silent_reason_ = "no focal points since the emergency stop was lifted";
  publishState(in_force_.stamp);
  response.success = true;
  response.message = "the emergency stop is lifted";
  return true;
}

void GatedArray::publishState(ros::Time stamp) {
  auto state = boost::make_shared<ArrayState>();
  state->header.stamp = stamp;
  state->header.frame_id = frame::array;
  state->device = device_;
  state->emitting = emitting_;
  state->silent_reason = silent_reason_;
  state->frames_sent = sent_;
  state->frames_rejected = rejected_;
  state->frames_late = late_;
  state->latency = static_cast<float>(latency_);
  state->head_spl = static_cast<float>(head_spl_);
  state_.publish(state);
}

void GatedArray::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const std::string fault = output_.fault();
  if (!fault.empty())
    status.summary(Level::ERROR, fault);
  else if (gate_.stopped())
    status.summary(Level::ERROR, "emergency stop");
  else if (!open_)
    status.summary(Level::WARN, "silent: " + silent_reason_);
  else
    status.summary(Level::OK, emitting_ ? "emitting" : "silent: no focal points");
  status.add("device", device_);
  status.add("frames a second", frames_);
  status.add("frames sent", sent_);
  status.add("frames rejected", rejected_);
  status.add("frames late", late_);
  status.add("head, dB SPL", head_spl_);
  std::sort(latencies_.begin(), latencies_.end());
  for (const auto& [name, share] :
       {std::pair("median", 0.5), {"90 %", 0.9}, {"99 %", 0.99}, {"longest", 1.0}})
    if (check_stamps_ && !latencies_.empty())
      status.add(
          std::string("latency, ms, ") + name,
          1e3 * latencies_[static_cast<std::size_t>(share * static_cast<double>(latencies_.size() - 1))]);
  latencies_.clear();
  frames_ = 0;
}

}  // namespace tactile_clay::nodes
