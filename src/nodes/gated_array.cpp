#include "nodes/gated_array.h"

#include <tactile_clay/ArrayState.h>
#include <tactile_clay/RenderingReport.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "device/loudness_meter.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/kept.h"
#include "nodes/message_check.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "nodes/transforms.h"
#include "safety/silence_times.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration watch_period(silence_times::seconds(silence_times::watch));
constexpr char emergency_stop[] = "emergency stop: silent until it is reset";
// s from hand to touch, of which people notice more (45 ms: Vogels 2004, doi 10.1518/hfes.46.1.118.30394).
constexpr double felt_late = 0.045;
constexpr std::size_t most_places = 256;                 // of a frame; no renderer makes more
constexpr std::size_t most_samples = most_focal_points;  // of skin, of a field: some 7 ms
constexpr double no_head_spl_cap = 200.0;                // dB, beyond what any array of these sizes reaches

/// What this run keeps to: an earlier one on the same master may have had other limits.
void tellLimits(const device::SafetyGateConfig& config, const std::string& node) {
  std::ostringstream limits;
  limits << config.pressure_cap << " Pa anywhere in the workspace, ";
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

/// What of the gate is set at its start alone, and the limits where no parameter says another.
/// \param simulated such an array keeps to no level at the head unless one is given
device::SafetyGateConfig gateConfig(const ros::NodeHandle& nh, bool simulated,
                                    std::set<device::Rule> without) {
  device::SafetyGateConfig config;
  config.without = std::move(without);
  for (const device::Rule rule : config.without)
    ROS_WARN("safety gate without its rule %s, as ~gate_without says", device::nameOf(rule).c_str());
  if (simulated) config.head_spl_cap = no_head_spl_cap;
  const auto text = [](const Eigen::Vector3d& v) {
    return std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z());
  };
  config.low = pointParam(nh, "workspace_low", text(config.low));
  config.high = pointParam(nh, "workspace_high", text(config.high));
  return config;
}

device::StampCheck::Mode stampMode(const ros::NodeHandle& nh) {
  using Mode = device::StampCheck::Mode;
  bool check = true;
  if (nh.getParam("check_stamps", check)) return check ? Mode::on : Mode::off;
  const auto text = param<std::string>(nh, "check_stamps", "true");
  if (text == "auto") return Mode::found;
  if (text == "true" || text == "false") return text == "true" ? Mode::on : Mode::off;
  throw std::runtime_error("parameter " + nh.resolveName("check_stamps") +
                           ": expected true, false or auto, got '" + text + "'");
}

/// Whether this is the name that rosbag play takes.
bool isPlayer(const std::string& node) {
  return node.compare(node.rfind('/') + 1, 5, "play_") == 0;
}

device::Instrument instrumentOf(const device::SafetyGateConfig& config, const GatedArray::Output& output) {
  const ArrayModel& model = *output.model;
  const auto meter =
      std::make_shared<device::LoudnessMeter>(model.layout, model.acoustics, model.head_point, config);
  return {output.solve, [meter](const auto& drive, const auto& points) { return (*meter)(drive, points); },
          output.scalable, output.solve_field};
}

void warn(const std::string& line) {
  if (!line.empty()) ROS_WARN_THROTTLE(1.0, "%s", line.c_str());
}

}  // namespace

std::set<device::Rule> rulesLeftOut(const ros::NodeHandle& private_nh, const std::string& device,
                                    bool harmless) {
  std::set<device::Rule> rules;
  for (const std::string& rule : param(private_nh, "gate_without", std::vector<std::string>())) {
    rules.insert(device::ruleOf(rule));
    if (!harmless)
      throw std::runtime_error("parameter " + private_nh.resolveName("gate_without") +
                               ": leaves out the rule '" + rule + "', expected none: array '" + device +
                               "' is real, and only simulated and debug arrays can do without a rule");
  }
  return rules;
}

void readLimits(Settings& settings, device::SafetyGateConfig& config, const device::SafetyGateConfig* most) {
  for (const device::Limit& limit : device::limits) {
    double& value = config.*limit.value;
    const double high = most ? most->*limit.value : limit.high;
    try {
      value = settings.number(limit.name, value, limit.low, high, limit.meaning);
    } catch (const std::runtime_error& error) {
      if (!most) throw;
      throw std::runtime_error(error.what() +
                               std::string(": the gate is never made less strict than at its start"));
    }
  }
  config.validate();
}

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
      stop_mark_(keptFile(node_, ".stopped")),
      output_(std::move(output)),
      first_limits_(
          gateConfig(private_nh, !watch_in_lockstep, rulesLeftOut(private_nh, device, output_.harmless))),
      inbox_(private_nh),
      health_(nh, private_nh, "array", [this](auto& status) { diagnose(status); }) {
  live_ =
      std::make_unique<LiveParameters>(nh, private_nh, [this](Settings& settings) { return read(settings); });
  const auto coming = ultrasound::modulation(param<std::string>(private_nh, "modulation", "am"));
  const std::string objection = cannotPlay(static_cast<unsigned>(coming));
  if (!objection.empty())
    throw std::runtime_error("parameter " + private_nh.resolveName("modulation") + ": " + objection);
  lockstep_ = param(private_nh, "lockstep", false);
  // In lockstep the clock is that of the stamps.
  stamps_.emplace(lockstep_ ? device::StampCheck::Mode::off : stampMode(private_nh),
                  gate_->config().stale_timeout);
  watch_ = watch_in_lockstep || !lockstep_;
  static_transforms_->send(transformMessage(
      frame::world, frame::array, poseParam(private_nh, "array_pose", "0 0 -0.15 0 0 0"), ros::Time::now()));

  const unsigned queue = lockstep_ ? 0 : 1;
  gate_->start();
  if (isMarked(stop_mark_)) {
    stopped_ = true;
    ++stops_;
    silent_reason_ = emergency_stop;
    ROS_WARN("array '%s' was started again: the emergency stop of before holds until it is reset",
             device_.c_str());
  }
  if (coming == ultrasound::Modulation::field)
    rendering_ = nh.advertise<RenderingReport>(topic::rendering, queue);
  state_ = nh.advertise<ArrayState>(topic::array_state, lockstep_ ? 0 : 10, true);
  // In lockstep each state answers a frame.
  if (!lockstep_) publishState();
  stop_switch_ = std::make_unique<StopSwitch>(
      nh, private_nh, [this] { return stop(); }, [this] { return reset(); });
  subscriber_ = inbox_.subscribe<FocalPointArray>(
      nh, topic::focal_points, queue, [this](const auto& message) { receive(message); },
      [this](const std::string& reason) { refuse(reason); });
  hands_subscriber_ = inbox_.subscribe<TrackedHands>(nh, topic::hands_tracked, queue,
                                                     [this](const auto& hands) { seeHands(hands); });
  if (stamps_->mode() == device::StampCheck::Mode::found)
    publisher_subscriber_ = nh.subscribe<TrackedHands>(
        topic::hands_tracked, 1,
        boost::function<void(const ros::MessageEvent<const TrackedHands>&)>(
            [this](const auto& event) { seePublisher(event.getPublisherName()); }));
  if (watch_)
    supervisors_ =
        std::make_unique<Supervisors>(param<std::string>(private_nh, "supervisors", "roslaunch master"));
  timer_ = nh.createWallTimer(watch_period, [this](const ros::WallTimerEvent&) { watch(); });
}

GatedArray::~GatedArray() {
  subscriber_.shutdown();
  hands_subscriber_.shutdown();
  publisher_subscriber_.shutdown();
  timer_.stop();
  stop_switch_.reset();
  output_.silence(in_force_);
}

void GatedArray::seeHands(const TrackedHands::ConstPtr& hands) {
  hands_came_ = ros::SteadyTime::now();
  hands_stamp_ = hands->header.stamp;
  hands_tracked_ = !hands->hands.empty();
}

void GatedArray::seePublisher(const std::string& name) {
  if (name == hands_publisher_) return;
  hands_publisher_ = name;
  stamps_->restart();
}

/// Tells it when stamps are found to be of a recording.
device::StampCheck::Age GatedArray::ageOf(const ros::Time& stamp) {
  const double behind = secondsBetween(stamp, ros::Time::now());
  const bool before = stamps_->ofRecording();
  const device::StampCheck::Age age = (*stamps_)(behind, isPlayer(hands_publisher_));
  if (stamps_->ofRecording() && !before)
    ROS_WARN_THROTTLE(1.0,
                      "array '%s': stamps of focal points are %.1f s behind this computer's clock; they are "
                      "taken for those "
                      "of a recording that is played, and not asked for their age. If they are live, compare "
                      "the hosts' clocks",
                      device_.c_str(), behind);
  return age;
}

device::Occasion GatedArray::occasion(ros::Time stamp) {
  device::Occasion occasion;
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
  const unsigned last = static_cast<unsigned>(ultrasound::Modulation::field);
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
  using ultrasound::Modulation;
  // One after the other, or samples that share the field.
  const bool any_number =
      emission.modulation == Modulation::spatiotemporal || emission.modulation == Modulation::field;
  if (!any_number && output_.max_points > 0 && count > output_.max_points)
    return more(output_.max_points, " focal points at a time");
  if (emission.modulation == Modulation::field)
    return count > most_samples ? more(most_samples, " samples of skin in a frame") : "";
  return count > most_places ? more(most_places, " focal points in a frame") : "";
}

/// The gate learns of emergency stops here, for it belongs to the thread of the callbacks.
void GatedArray::heedStop() {
  const unsigned stops = stops_;
  if (stops != heeded_) gate_->stop();
  heeded_ = stops;
  if (!stopped_) gate_->reset();
}

device::Verdict GatedArray::judge(const FocalPointArray& message, const device::StampCheck::Age& age) {
  device::Verdict verdict;
  device::Occasion occasion = this->occasion(message.header.stamp);
  occasion.age = age.age;
  const std::string cannot_play = cannotPlay(message.modulation);
  if (frameName(message.header.frame_id) != frame::array) {
    verdict.reason =
        "focal points in frame '" + message.header.frame_id + "', expected '" + frame::array + "'";
  } else if (!cannot_play.empty()) {
    verdict.reason = cannot_play;
  } else if (!unsupervised_.empty() && !gate_->stopped()) {
    verdict.reason = unsupervised_;
  } else {
    device::Emission emission;
    emission.points = toCore(message.points);
    emission.modulation_frequency = message.modulation_frequency;
    emission.modulation = static_cast<ultrasound::Modulation>(message.modulation);
    verdict.reason = tooMany(emission);
    if (verdict.passes()) verdict = gate_->check(emission, occasion);
  }
  return verdict;
}

// Focal points that are none leave nothing sounding that was there before.
void GatedArray::refuse(const std::string& reason) {
  std::string line;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++rejected_;
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
  const device::StampCheck::Age age = ageOf(message->header.stamp);
  if (!lockstep_ && !stamps_->ofRecording()) latencies_.push_back(age.age);
  const bool in_time = gate_->tick(age.age).passes();
  device::Verdict verdict = judge(*message, age);
  if (!in_time && !gate_->stopped() && !age.clocks.empty()) verdict.reason += "; " + age.clocks;
  lowered_ = verdict.lowered;
  std::string line;
  bool open = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    in_force_ = message->header;
    latency_ = age.age;
    head_spl_ = verdict.head_spl.value_or(0.0);
    if (stops_ != heeded_) {
      line = close(emergency_stop);  // it came while the gate was judging
    } else if (verdict.passes()) {
      line = emit(verdict.sound);
    } else {
      ++(in_time || stopped_ ? rejected_ : late_);
      line = close(verdict.reason);
    }
    open = open_;
    publishState();
  }
  publishField(verdict, *message);
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
    ++rejected_;
    return close(error.what());
  }
  ++sent_;
  open_ = true;
  emitting_ = !sound.parts.empty();
  // In lockstep the hands of this frame may come after its points, so that the reason would differ between
  // runs.
  const bool no_hand = !lockstep_ && hands_came_ && !hands_tracked_;
  silent_reason_ = emitting_ ? "" : no_hand ? "no focal points: no hand is tracked" : "no focal points";
  return "";
}

std::string GatedArray::close(const std::string& reason) {
  output_.silence(in_force_);
  const bool tells = open_ || !told_silence_;
  told_silence_ = true;
  open_ = emitting_ = false;
  head_spl_ = 0.0;
  silent_reason_ = reason;
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
  if (!mark(stop_mark_, true)) stop_line_ = "emergency stop: it is lost if this node has to be started again";
  return "the array is silent until array/reset";
}

std::string GatedArray::reset() {
  stopped_ = false;
  mark(stop_mark_, false);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!open_) silent_reason_ = "no focal points since the emergency stop was lifted";
  publishState();
  return "the emergency stop is lifted";
}

void GatedArray::publishState() {
  auto state = boost::make_shared<ArrayState>();
  state->header.stamp = in_force_.stamp;
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

/// Of a field: what is wanted on each sample of skin, and what it is given. Nothing wanted: no samples.
void GatedArray::publishField(const device::Verdict& verdict, const FocalPointArray& message) {
  if (!rendering_) return;
  auto report = boost::make_shared<RenderingReport>();
  report->header = message.header;
  if (verdict.field) {
    const ultrasound::FieldSolution& field = *verdict.field;
    const ultrasound::Acoustics& air = output_.model->acoustics;
    double both = 0.0, square = 0.0;
    for (std::size_t k = 0; k < field.wanted.size(); ++k) {
      const double clay = verdict.sound.emission.points[k].pressure;
      const double given = ultrasound::radiationPressure(air, field.reached[k]);
      report->wanted.push_back(static_cast<float>(ultrasound::radiationPressure(air, field.wanted[k])));
      report->granted.push_back(static_cast<float>(given));
      both += given * clay;
      square += clay * clay;
    }
    if (square > 0.0) report->gain = static_cast<float>(both / square);
    report->error = report->weighted_error = static_cast<float>(field.error);
    tellForce(message, *report);
  }
  rendering_.publish(report);
}

void GatedArray::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const std::string fault = output_.fault();
  std::sort(latencies_.begin(), latencies_.end());
  const auto latency = [this](double share) {
    return latencies_[static_cast<std::size_t>(share * static_cast<double>(latencies_.size() - 1))];
  };
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!fault.empty())
      status.summary(Level::ERROR, fault);
    else if (stopped_)
      status.summary(Level::ERROR, "emergency stop");
    else if (!open_)
      status.summary(Level::WARN, "silent: " + silent_reason_);
    else if (late_ > told_late_)
      status.summary(Level::WARN, "frames are late: " + std::to_string(late_ - told_late_));
    else if (!latencies_.empty() && latency(0.99) > felt_late)
      status.summary(Level::WARN, "slow: a touch is felt as late");
    else if (emitting_ && !lowered_.empty())
      status.summary(Level::OK, "emitting, made weaker by " + lowered_);
    else
      status.summary(Level::OK, emitting_ ? "emitting" : "silent: " + silent_reason_);
    status.add("device", device_);
    status.add("frames a second", frames_);
    status.add("frames sent", sent_);
    status.add("frames rejected", rejected_);
    status.add("frames late", late_);
    told_late_ = late_;
    status.add("head, dB SPL", head_spl_);
  }
  for (const auto& [name, share] :
       {std::pair("median", 0.5), {"90 %", 0.9}, {"99 %", 0.99}, {"longest", 1.0}})
    if (!latencies_.empty()) status.add(std::string("latency, ms, ") + name, 1e3 * latency(share));
  latencies_.clear();
  inbox_.report(status);
  frames_ = 0;
}

}  // namespace tactile_clay::nodes
