#include "nodes/gated_array.h"

#include <tactile_clay/RenderingReport.h>

#include <stdexcept>

#include "nodes/emission_message.h"
#include "nodes/field_report.h"
#include "nodes/frame_name.h"
#include "nodes/gate_parameters.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "nodes/transforms.h"
#include "safety/silence_times.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration watch_period(silence_times::seconds(silence_times::watch));
constexpr char emergency_stop[] = "emergency stop: silent until it is reset";
// s from hand to touch. People notice a longer delay (45 ms: Vogels 2004, doi 10.1518/hfes.46.1.118.30394).
constexpr double felt_late = 0.045;

device::Instrument instrumentOf(const device::SafetyGateConfig& config, const GatedArray::Output& output) {
  return {output.solve, loudnessOf(output.model, config), output.scalable, output.solve_field};
}

void warn(const std::string& line) {
  if (!line.empty()) ROS_WARN_THROTTLE(1.0, "%s", line.c_str());
}

}  // namespace

LiveParameters::Apply GatedArray::read(Settings& settings) {
  device::SafetyGateConfig config = first_limits_;
  readLimits(settings, config, settings.running() ? &first_limits_ : nullptr);
  return [this, config] {
    if (gate_) {
      gate_->tighten(config, instrumentOf(config, output_));
    } else {
      first_limits_ = config;
      gate_.emplace(config, instrumentOf(config, output_));
    }
    tellLimits(config, node_);
  };
}

GatedArray::GatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh, const std::string& device,
                       bool watch_in_lockstep, Output output)
    : device_(device),
      node_(private_nh.getNamespace()),
      output_(std::move(output)),
      first_limits_(
          gateConfig(private_nh, !watch_in_lockstep, rulesLeftOut(private_nh, device, output_.harmless))),
      inbox_(private_nh),
      health_(nh, private_nh, "array", [this](auto& status) { diagnose(status); }) {
  standing_.device = device_;
  standing_.silent_reason = "no focal points have come";
  live_ =
      std::make_unique<LiveParameters>(nh, private_nh, [this](Settings& settings) { return read(settings); });
  const auto coming = ultrasound::modulation(param<std::string>(private_nh, "modulation", "am"));
  const std::string objection = output_.repertoire.objection(static_cast<unsigned>(coming));
  if (!objection.empty())
    throw std::runtime_error("parameter " + private_nh.resolveName("modulation") + ": " + objection);
  ROS_INFO("%s: array '%s' plays modulation '%s'", node_.c_str(), device_.c_str(),
           ultrasound::nameOf(coming));
  lockstep_ = param(private_nh, "lockstep", false);
  // In lockstep time is measured by the stamps.
  const auto stamp_mode = lockstep_ ? device::StampCheck::Mode::off : stampMode(private_nh);
  arrivals_.emplace(device_, lockstep_, device::StampCheck(stamp_mode, gate_->config().stale_timeout));
  watch_ = watch_in_lockstep || !lockstep_;
  static_transforms_->send(transformMessage(
      frame::world, frame::array, poseParam(private_nh, "array_pose", "0 0 -0.15 0 0 0"), ros::Time::now()));

  const unsigned queue = lockstep_ ? 0 : 1;
  gate_->start();
  if (ultrasound::isField(coming)) rendering_ = nh.advertise<RenderingReport>(topic::rendering, queue);
  state_ = nh.advertise<ArrayState>(topic::array_state, lockstep_ ? 0 : 10, true);
  // In lockstep each state is the answer to a frame.
  if (!lockstep_) publishState();
  stop_switch_ = std::make_unique<StopSwitch>(
      nh, private_nh, [this] { return stop(); }, [this] { return reset(); });
  subscriber_ = inbox_.subscribe<FocalPointArray>(
      nh, topic::focal_points, queue, [this](const auto& message) { receive(message); },
      [this](const std::string& reason) { refuse(reason); });
  hands_subscriber_ = inbox_.subscribe<TrackedHands>(
      nh, topic::hands_tracked, queue,
      [this](const auto& hands, const std::string& from) { arrivals_->seeHands(*hands, from); });
  if (watch_)
    supervisors_ =
        std::make_unique<Supervisors>(param<std::string>(private_nh, "supervisors", "roslaunch master"));
  timer_ = nh.createWallTimer(watch_period, [this](const ros::WallTimerEvent&) { watch(); });
}

GatedArray::~GatedArray() {
  subscriber_.shutdown();
  hands_subscriber_.shutdown();
  timer_.stop();
  stop_switch_.reset();
  output_.silence(in_force_);
}

/// Passes emergency stops on to the gate, which belongs to the thread of the callbacks.
void GatedArray::heedStop() {
  const unsigned stops = stops_;
  if (stops != heeded_) gate_->stop();
  heeded_ = stops;
  if (!stopped_) gate_->reset();
}

device::Verdict GatedArray::judge(const FocalPointArray& message, const device::StampCheck::Age& age) {
  device::Verdict verdict;
  device::Occasion occasion = arrivals_->occasion(message.header.stamp);
  occasion.age = age.age;
  const std::string cannot_play = output_.repertoire.objection(message.modulation);
  if (frameName(message.header.frame_id) != frame::array) {
    verdict.reason =
        "focal points in frame '" + message.header.frame_id + "', expected '" + frame::array + "'";
  } else if (!cannot_play.empty()) {
    verdict.reason = cannot_play;
  } else if (!unsupervised_.empty() && !gate_->stopped()) {
    verdict.reason = unsupervised_;
  } else {
    const device::Emission emission = emissionOf(message);
    verdict.reason = output_.repertoire.objection(emission);
    if (verdict.passes()) verdict = gate_->check(emission, occasion);
  }
  return verdict;
}

// A message with invalid focal points silences the array, also what was playing before.
void GatedArray::refuse(const std::string& reason) {
  std::string line;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++standing_.frames_rejected;
    line = close(stopped_ ? emergency_stop : reason);
    publishState();
  }
  gate_->fallSilent();
  warn(line);
}

void GatedArray::receive(const FocalPointArray::ConstPtr& message) {
  heedStop();
  live_->begin(message->header.stamp);
  ++frames_;
  const device::StampCheck::Age age = arrivals_->ageOf(message->header.stamp);
  if (!lockstep_ && !arrivals_->ofRecording()) latencies_.add(age.age);
  const bool in_time = gate_->tick(age.age).passes();
  device::Verdict verdict = judge(*message, age);
  if (!in_time && !gate_->stopped() && !age.clocks.empty()) verdict.reason += "; " + age.clocks;
  lowered_ = verdict.lowered;
  std::string line;
  bool open = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    in_force_ = message->header;
    standing_.latency = static_cast<float>(age.age);
    standing_.head_spl = static_cast<float>(verdict.head_spl.value_or(0.0));
    if (stops_ != heeded_) {
      line = close(emergency_stop);  // a stop came while the gate was judging
    } else if (verdict.passes()) {
      line = emit(verdict.sound);
    } else {
      ++(in_time || stopped_ ? standing_.frames_rejected : standing_.frames_late);
      line = close(verdict.reason);
    }
    open = open_;
    publishState();
  }
  if (rendering_) rendering_.publish(fieldReport(verdict, *message, output_.model.acoustics));
  if (!open)
    gate_->fallSilent();
  else if (output_.show)
    output_.show(verdict.sound, message->header);
  warn(line);
}

std::string GatedArray::emit(const device::Sound& sound) {
  last_passed_ = ros::SteadyTime::now();
  try {
    output_.emit(sound, in_force_);
  } catch (const std::exception& error) {
    ++standing_.frames_rejected;
    return close(error.what());
  }
  ++standing_.frames_sent;
  open_ = true;
  standing_.emitting = !sound.parts.empty();
  // In lockstep the hands of this frame may come after its points. The reason would then differ between runs.
  const bool no_hand = !lockstep_ && arrivals_->handsAreGone();
  standing_.silent_reason = standing_.emitting ? ""
                            : no_hand          ? "no focal points: no hand is tracked"
                                               : "no focal points";
  return "";
}

std::string GatedArray::close(const std::string& why) {
  const std::string reason = values::printableLine(why);  // names of messages may have line breaks
  output_.silence(in_force_);
  const bool tells = open_ || !told_silence_;
  told_silence_ = true;
  open_ = false;
  standing_.emitting = false;
  standing_.head_spl = 0.0f;
  standing_.silent_reason = reason;
  return tells ? "array '" + device_ + "' is silent: " + reason : "";
}

void GatedArray::watch() {
  heedStop();
  const std::string missing = supervisors_ ? supervisors_->missing() : "";
  const bool changed = missing != unsupervised_;
  unsupervised_ = missing;
  const double age = watch_ ? (ros::SteadyTime::now() - last_passed_).toSec() : 0.0;
  std::string reason = missing, line, stopped;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped.swap(stop_line_);
    if (missing.empty() && open_) reason = gate_->tick(age).reason;
    if (missing.empty() && !open_ && changed) reason = "no focal points have come since";
    if (!stopped_ && !reason.empty() && (open_ || changed)) {
      line = close(reason);
      publishState();
      gate_->fallSilent();
    }
  }
  if (!stopped.empty()) ROS_WARN("%s", stopped.c_str());
  if (!line.empty() && !missing.empty())
    ROS_WARN("%s", line.c_str());
  else
    warn(line);
}

std::string GatedArray::stop() {
  stopped_ = true;
  ++stops_;
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::string line = close(emergency_stop);
  if (!line.empty()) stop_line_ = line;
  publishState();
  return "the array is silent until array/reset";
}

std::string GatedArray::reset() {
  stopped_ = false;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!open_) standing_.silent_reason = "no focal points since the emergency stop was lifted";
  publishState();
  return "the emergency stop is lifted";
}

void GatedArray::publishState() {
  standing_.header.stamp = in_force_.stamp;
  standing_.header.frame_id = frame::array;
  state_.publish(boost::make_shared<ArrayState>(standing_));
}

void GatedArray::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const std::string fault = output_.fault();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!fault.empty())
      status.summary(Level::ERROR, fault);
    else if (stopped_)
      status.summary(Level::ERROR, "emergency stop");
    else if (!open_)
      status.summary(Level::WARN, "silent: " + standing_.silent_reason);
    else if (standing_.frames_late > told_late_)
      status.summary(Level::WARN, "frames are late: " + std::to_string(standing_.frames_late - told_late_));
    else if (latencies_.within(0.99) > felt_late)
      status.summary(Level::WARN, "slow: a touch is felt as late");
    else if (standing_.emitting && !lowered_.empty())
      status.summary(Level::OK, "emitting, made weaker by " + lowered_);
    else
      status.summary(Level::OK, standing_.emitting ? "emitting" : "silent: " + standing_.silent_reason);
    status.add("device", device_);
    status.add("frames per second", frames_);
    status.add("frames sent", standing_.frames_sent);
    status.add("frames rejected", standing_.frames_rejected);
    status.add("frames late", standing_.frames_late);
    told_late_ = standing_.frames_late;
    status.add("head, dB SPL", standing_.head_spl);
  }
  latencies_.report(status);
  inbox_.report(status);
  frames_ = 0;
}

}  // namespace tactile_clay::nodes
