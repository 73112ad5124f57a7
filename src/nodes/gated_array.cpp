#include "nodes/gated_array.h"

#include <tactile_clay/ArrayState.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration watch_period(0.02);
constexpr double no_head_spl_cap = 200.0;  // dB, beyond what any array of these sizes reaches
constexpr std::size_t most_places = 256;   // of a frame; no renderer makes more

/// What this run keeps to: an earlier one on the same master may have had other limits.
void tellLimits(const device::SafetyGateConfig& config, const std::string& node) {
  std::ostringstream limits;
  limits << config.pressure_cap << " Pa at a focal point, ";
  if (config.head_spl_cap < no_head_spl_cap)
    limits << config.head_spl_cap << " dB at the head, ";
  else
    limits << "any level at the head, ";
  limits << "intensity " << config.intensity_cap << ", " << config.stale_timeout
         << " s without focal points or hands, and within (" << config.low.transpose() << ") to ("
         << config.high.transpose() << ") m of the array";
  for (const device::Rule rule : config.without) limits << "; WITHOUT its rule " << device::nameOf(rule);
  ROS_INFO("%s: the safety gate allows at most %s", node.c_str(), limits.str().c_str());
}

/// \param real whether somebody may be hurt: a simulated array keeps to no level at the head unless one is
/// given
device::SafetyGateConfig gateConfig(const ros::NodeHandle& nh, bool real) {
  device::SafetyGateConfig config;
  if (!real) config.head_spl_cap = no_head_spl_cap;
  config.stale_timeout = paramIn(nh, "stale_timeout", config.stale_timeout, 0.001, 10.0);
  config.intensity_cap = paramIn(nh, "intensity_cap", config.intensity_cap, 0.0, 1.0);
  const auto text = [](const Eigen::Vector3d& v) {
    return std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z());
  };
  config.low = pointParam(nh, "workspace_low", text(config.low));
  config.high = pointParam(nh, "workspace_high", text(config.high));
  config.intensity_slew = paramIn(nh, "intensity_slew", config.intensity_slew, 0.001, 1e6);
  config.pressure_cap = paramIn(nh, "pressure_cap", config.pressure_cap, 1.0, 1e6);
  config.head_spl_cap = paramIn(nh, "head_spl_cap", config.head_spl_cap, 0.0, 200.0);
  for (const std::string& rule : param(nh, "gate_without", std::vector<std::string>())) {
    config.without.insert(device::ruleOf(rule));
    ROS_WARN("safety gate without its rule %s, as ~gate_without says", rule.c_str());
  }
  tellLimits(config, nh.getNamespace());
  return config;
}

}  // namespace

GatedArray::GatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh, const std::string& device,
                       bool watch_in_lockstep, Output output)
    : device_(device),
      gate_(gateConfig(private_nh, watch_in_lockstep)),
      output_(std::move(output)),
      inbox_(private_nh),
      health_(nh, private_nh, "array", [this](auto& status) { diagnose(status); }) {
  const auto coming = ultrasound::modulation(param<std::string>(private_nh, "modulation", "am"));
  const std::string objection = cannotPlay(static_cast<unsigned>(coming));
  if (!objection.empty())
    throw std::runtime_error("parameter " + private_nh.resolveName("modulation") + ": " + objection);
  lockstep_ = param(private_nh, "lockstep", false);
  // Stamps of a recording are of another clock; what is too old is then told by when it arrives.
  check_stamps_ = param(private_nh, "check_stamps", true) && !lockstep_;
  watch_ = watch_in_lockstep || !lockstep_;
  static_transforms_->send(transformMessage(
      frame::world, frame::array, poseParam(private_nh, "array_pose", "0 0 -0.15 0 0 0"), ros::Time::now()));

  const unsigned queue = lockstep_ ? 0 : 1;
  stop_server_ = private_nh.advertiseService("stop", &GatedArray::stop, this);
  reset_server_ = private_nh.advertiseService("reset", &GatedArray::reset, this);
  gate_.start();
  subscriber_ = inbox_.subscribe<FocalPointArray>(
      nh, topic::focal_points, queue, [this](const auto& message) { receive(message); },
      [this](const std::string& reason) { refuse(reason); });
  hands_subscriber_ = inbox_.subscribe<TrackedHands>(nh, topic::hands_tracked, queue,
                                                     [this](const auto& hands) { seeHands(hands); });
  state_ = nh.advertise<ArrayState>(topic::array_state, lockstep_ ? 0 : 10);
  timer_ = nh.createWallTimer(watch_period, [this](const ros::WallTimerEvent&) { watch(); });
}

GatedArray::~GatedArray() {
  subscriber_.shutdown();
  hands_subscriber_.shutdown();
  timer_.stop();
  output_.silence(in_force_);
}

void GatedArray::seeHands(const TrackedHands::ConstPtr& hands) {
  hands_came_ = ros::SteadyTime::now();
  hands_stamp_ = hands->header.stamp;
  hands_tracked_ = !hands->hands.empty();
}

device::Occasion GatedArray::occasion(ros::Time stamp) {
  device::Occasion occasion;
  occasion.age = latency_;
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (lockstep_) {
    // Repeats itself: the clock is that of the stamps, and the hands count once they are no older than the
    // points.
    occasion.since_last = secondsBetween(in_force_.stamp, stamp);
    occasion.hands_tracked = hands_tracked_ || !hands_came_ || hands_stamp_ < stamp;
  } else {
    occasion.since_last = (now - last_came_).toSec();
    // An array that never heard of hands is somebody's without a tracker.
    occasion.hands_tracked = hands_tracked_ || !hands_came_;
    occasion.hands_age = hands_came_ ? (now - *hands_came_).toSec() : 0.0;
  }
  last_came_ = now;
  return occasion;
}

std::string GatedArray::cannotPlay(unsigned modulation) const {
  std::string list;
  for (const ultrasound::Modulation known : output_.modulations) {
    if (modulation == static_cast<unsigned>(known)) return "";
    list += (list.empty() ? "" : ", ") + std::string(ultrasound::nameOf(known));
  }
  const unsigned last = static_cast<unsigned>(ultrasound::Modulation::spatiotemporal);
  const std::string name = modulation > last
                               ? std::to_string(modulation)
                               : ultrasound::nameOf(static_cast<ultrasound::Modulation>(modulation));
  std::ostringstream line;
  line << "modulation is '" << name << "', array '" << device_ << "' can do " << list;
  if (output_.max_rate > 0.0)
    line << " only, for it takes " << std::lround(output_.max_rate) << " updates a second";
  return line.str();
}

/// Empty, or why there are too many points: phases and loudness of hundreds would take seconds, in which no
/// emergency stop is heard.
std::string GatedArray::tooMany(const device::Emission& emission) const {
  const auto more = [&](std::size_t most, const char* what) {
    return std::to_string(emission.points.size()) + what + ", array '" + device_ + "' takes at most " +
           std::to_string(most);
  };
  const std::size_t count = emission.points.size();
  const bool one_by_one = emission.modulation == ultrasound::Modulation::spatiotemporal;
  if (!one_by_one && output_.max_points > 0 && count > output_.max_points)
    return more(output_.max_points, " focal points at a time");
  return count > most_places ? more(most_places, " focal points in a frame") : "";
}

void GatedArray::receive(const FocalPointArray::ConstPtr& message) {
  ++frames_;
  device::Emission emission;
  emission.points = toCore(message->points);
  emission.modulation_frequency = message->modulation_frequency;
  latency_ = check_stamps_ ? secondsBetween(message->header.stamp, ros::Time::now()) : 0.0;
  latencies_.push_back(latency_);
  const device::Occasion occasion = this->occasion(message->header.stamp);
  in_force_ = message->header;

  device::Verdict verdict;
  const std::string cannot_play = cannotPlay(message->modulation);
  const bool in_time = gate_.tick(latency_).passes();
  if (frameName(message->header.frame_id) != frame::array) {
    verdict.reason =
        "focal points in frame '" + message->header.frame_id + "', expected '" + frame::array + "'";
  } else if (!cannot_play.empty()) {
    verdict.reason = cannot_play;
  } else {
    emission.modulation = static_cast<ultrasound::Modulation>(message->modulation);
    verdict.reason = tooMany(emission);
    if (verdict.passes()) verdict = gate_.check(emission, occasion, output_.loudness);
  }
  head_spl_ = verdict.head_spl.value_or(0.0);
  lowered_ = verdict.lowered;
  if (verdict.passes()) {
    emit(verdict.emission);
  } else {
    ++(in_time || gate_.stopped() ? rejected_ : late_);
    close(verdict.reason);
  }
  publishState(in_force_.stamp);
}

// Focal points that are none leave nothing sounding that was there before.
void GatedArray::refuse(const std::string& reason) {
  ++rejected_;
  close(reason);
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
  gate_.fallSilent();
  if (open_ || !told_silence_)
    ROS_WARN_THROTTLE(1.0, "array '%s' is silent: %s", device_.c_str(), reason.c_str());
  told_silence_ = true;
  open_ = emitting_ = false;
  head_spl_ = 0.0;
  silent_reason_ = reason;
}

void GatedArray::watch() {
  if (!open_) return;
  const double age = watch_ ? (ros::SteadyTime::now() - last_passed_).toSec() : 0.0;
  const device::Verdict verdict = gate_.tick(age);
  if (verdict.passes()) return;
  close(verdict.reason);
  publishState(in_force_.stamp);
}

bool GatedArray::stop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  gate_.stop();
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
  else if (emitting_ && !lowered_.empty())
    status.summary(Level::OK, "emitting, made weaker by " + lowered_);
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
  inbox_.report(status);
  frames_ = 0;
}

}  // namespace tactile_clay::nodes
