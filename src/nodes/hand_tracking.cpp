#include "nodes/hand_tracking.h"

#include <tactile_clay/TrackedHands.h>

#include <algorithm>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "hand/hand_check.h"
#include "nodes/conversions.h"
#include "nodes/exit_code.h"
#include "nodes/frame_name.h"
#include "nodes/graph_connections.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/topics.h"
#include "safety/silence_times.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration graph_patience(15.0);  // live
const ros::WallDuration clock_patience(10.0);  // for a first time on /clock
const ros::WallDuration standing_clock(5.0);   // until it is told, and again
const std::vector<std::string> whole_graph = {topic::hands_tracked, topic::hands_skin,
                                              topic::clay_contacts, topic::hands_pressure,
                                              topic::focal_points,  topic::array_state};
const std::vector<std::string> side_topics = {
    topic::clay_particles,    topic::clay_status,        topic::joint_states, topic::array_drive,
    topic::array_measured,    topic::array_field,        topic::rendering,    topic::acoustics,
    topic::joint_states_left, topic::joint_states_right, topic::hands_bones,  topic::changes};

constexpr std::chrono::milliseconds live_patience = silence_times::tracker_silent;
constexpr std::chrono::milliseconds recording_patience(100);

std::string seconds(const ros::WallDuration& duration) {
  std::ostringstream text;
  text << duration.toSec() << " s";
  return text.str();
}

}  // namespace

hand::CleanConfig cleanConfig(Settings& s) {
  hand::CleanConfig config;
  constexpr double any = std::numeric_limits<double>::infinity();  // the core checks ranges
  for (const auto& [name, filter, unit] : {std::tuple("position", &config.position, "m"),
                                           std::tuple("orientation", &config.orientation, "rad")}) {
    const std::string prefix = name;
    filter->min_cutoff = s.number(prefix + "_min_cutoff", filter->min_cutoff, 0.0, any,
                                  "Hz, of the One-Euro filter at rest: less is smoother, and later");
    filter->beta = s.number(prefix + "_beta", filter->beta, 0.0, any,
                            std::string("1/") + unit + ", by which its cutoff grows with the speed");
  }
  config.prediction = s.number("prediction", config.prediction, 0.0, hand::most_prediction,
                               "s that tracked hands are predicted ahead");
  validate(config);
  return config;
}

LiveParameters::Apply HandTracking::read(Settings& settings) {
  const hand::CleanConfig config = cleanConfig(settings);
  return [this, config] {
    const std::lock_guard<std::mutex> lock(report_mutex_);
    cleaner_->configure(config);
  };
}

HandTracking::HandTracking(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : nh_(nh),
      source_name_(param<std::string>(private_nh, "source", "bag")),
      world_(frameName(param<std::string>(private_nh, "world_frame", frame::world))),
      rate_(paramIn(private_nh, "rate", 1.0, 0.01, 100.0)),
      duration_(paramIn(private_nh, "duration", 0.0, 0.0, 1e9)),
      lockstep_(param(private_nh, "lockstep", false)),
      answer_patience_(paramIn(private_nh, "answer_patience", 30.0, 0.1, 1e6)),
      source_("tactile_clay::hand::HandSource", "source of hands", source_name_),
      inbox_(private_nh),
      answers_(nh, inbox_),
      health_(nh, private_nh, "tracked hands", [this](auto& status) { diagnose(status); }) {
  static_transforms_->send(transformMessage(
      world_, frame::tracker, poseParam(private_nh, "tracker_pose", "0 0 0 0 0 0"), ros::Time::now()));

  hand::SourceOptions options;
  options.file = param<std::string>(private_nh, "file", "");
  options.url = param<std::string>(private_nh, "url", "");
  options.topic = param<std::string>(private_nh, "topic", "");
  if (options.topic.empty()) options.topic = topic::hands_tracked;
  options.loop = param(private_nh, "loop", false);
  const bool from_topic = source_name_ == "topic";
  if (from_topic) options.topic = nh.resolveName(options.topic);
  passes_by_ = from_topic && options.topic == nh.resolveName(topic::hands_tracked);
  const auto wanted = param<std::string>(private_nh, "clean", "auto");
  if (wanted != "auto" && wanted != "true" && wanted != "false")
    throw std::runtime_error("parameter " + private_nh.resolveName("clean") +
                             ": expected auto, true or false, got '" + wanted + "'");
  Settings filters(private_nh);
  cleanConfig(filters);  // what is wrong is told, in use or not
  source_->open(options);
  is_live_ = !source_->recorded();
  if (wanted == "true" || (wanted == "auto" && !source_->cleaned())) {
    cleaner_.emplace(hand::CleanConfig());
    live_ = std::make_unique<LiveParameters>(nh, private_nh,
                                             [this](Settings& settings) { return read(settings); });
  }
  // The cleaner bridges what is not seen anew.
  repeats_.emplace(cleaner_ ? std::chrono::nanoseconds(0) : repeats_patience);
  if (lockstep_ && !source_->recorded())
    throw std::runtime_error("lockstep: expected hands from a recording or none, got the live source '" +
                             source_name_ + "'");

  wait_for_graph_ = param(private_nh, "wait_for_graph", false) || lockstep_;
  for (const std::string& name : param(private_nh, "graph", whole_graph))
    graph_.required.push_back(nh.resolveName(name));
  for (const std::string& name : side_topics) graph_.optional.push_back(nh.resolveName(name));
  if (lockstep_) chain_.emplace(nh, graph_.required);
  const auto recorder = param<std::string>(private_nh, "recorder", "");
  if (!recorder.empty()) graph_.recorder = nh.resolveName(recorder);
  for (const std::string& name : param(private_nh, "unrecorded", std::vector<std::string>()))
    graph_.unrecorded.push_back(nh.resolveName(name));
  for (const std::string& name : param(private_nh, "recorded_first", std::vector<std::string>()))
    graph_.required.push_back(nh.resolveName(name));
  if (!passes_by_) publisher_ = nh.advertise<TrackedHands>(topic::hands_tracked, lockstep_ ? 0 : 1);
  thread_ = std::thread([this] {
    try {
      run();
    } catch (const std::exception& error) {
      ROS_FATAL("hand_tracking: %s", error.what());
      finish(1);
    }
  });
}

HandTracking::~HandTracking() {
  stopping_ = true;
  thread_.join();
}

void HandTracking::run() {
  waitForClock();
  if (wait_for_graph_ && source_->recorded()) waitForGraph();
  start_ = ros::SteadyTime::now();
  follow();
  if (stopped()) return;
  // The last sample may still be on its way through the graph; only lockstep insists on its answer.
  if (!lockstep_ && !passes_by_)
    answers_.wait(last_release_, ros::WallDuration(2.0), [this] { return stopped(); });
  // Recorders and displays get what they have been sent before the process goes.
  ros::WallDuration(0.3).sleep();
  ROS_INFO("hand_tracking: the input ended after %u frames", frames_.load());
  finish(0);
}

// With use_sim_time all times come from /clock. Without, they would stand still; a player of hands may bring
// it later.
void HandTracking::waitForClock() {
  const ros::SteadyTime start = ros::SteadyTime::now();
  while (!stopped() && !lockstep_ && source_name_ != "topic" && ros::Time::isSimTime() &&
         ros::Time::now().isZero()) {
    if (ros::SteadyTime::now() - start > clock_patience)
      throw std::runtime_error(
          "use_sim_time is true on this master, and no time came on /clock within 10 s: start the "
          "clock, or `rosparam delete /use_sim_time`");
    ros::WallDuration(0.05).sleep();
  }
}

// The throttle of the console goes by ROS time, and would stand still as well.
void HandTracking::tellStandingClock() {
  const ros::Time now = ros::Time::now();
  const ros::SteadyTime real = ros::SteadyTime::now();
  if (lockstep_ || !ros::Time::isSimTime() || now != clock_time_) {
    clock_time_ = now;
    clock_moved_ = real;
  } else if (real - clock_moved_ > standing_clock) {
    clock_moved_ = real;
    ROS_WARN(
        "hand_tracking: use_sim_time is true, and /clock stands still: samples have one and the same time");
  }
}

void HandTracking::waitForGraph() {
  const ros::WallTime start = ros::WallTime::now();
  const ros::WallDuration settled(0.3);  // a node that is connected may still be in its constructor
  ros::WallTime connected_since;
  while (!stopped()) {
    const std::string missing = missingConnection(graph_);
    const ros::WallTime now = ros::WallTime::now();
    if (!missing.empty()) connected_since = ros::WallTime();
    if (missing.empty() && connected_since.isZero()) connected_since = now;
    if (missing.empty() && now - connected_since >= settled) return;
    if (lockstep_ && now - start > answer_patience_)
      throw std::runtime_error("lockstep: the graph is not connected after " + seconds(answer_patience_) +
                               ": " + missing);
    if (!lockstep_ && now - start > graph_patience) {
      ROS_WARN("hand_tracking: starts although the graph is not connected: %s", missing.c_str());
      return;
    }
    ros::WallDuration(0.05).sleep();
  }
}

void HandTracking::follow() {
  while (!stopped() && !over()) {
    hand::TrackedFrame frame;
    const Read read = source_->read(frame, is_live_ ? live_patience : recording_patience);
    tellFault();
    if (read == Read::ended) return;
    if (read == Read::nothing) {
      holdHands();
      continue;
    }
    if (is_live_ && leaveOutRepeats(frame)) continue;
    const auto stamp = is_live_ ? liveStamp(frame) : recordingStamp(frame);
    if (!stamp || stopped()) return;
    frame.stamp = *stamp;
    source_frame_ = frame.frame_id;
    const hand::LeftOut left_out = leaveOutBadHands(frame);
    bad_hands_ += static_cast<unsigned>(left_out.hands);
    bad_fingers_ += static_cast<unsigned>(left_out.fingers);
    clean(frame);
    placeInWorld(frame, world_, transforms_);
    release(frame);
  }
}

// What a live tracker only repeats was not seen. True where nothing else is in the frame: it is then none.
bool HandTracking::leaveOutRepeats(hand::TrackedFrame& frame) {
  // On hands/tracked itself it is hand_simulator that leaves them out.
  if (passes_by_ || (source_name_ == "topic" && !freshStamp(frame.stamp))) return false;
  const std::chrono::nanoseconds now = std::chrono::steady_clock::now().time_since_epoch();
  const hand::LeftOut left_out = repeats_->leaveOutRepeats(frame.hands, now);
  repeated_hands_ += static_cast<unsigned>(left_out.hands);
  tell(left_out);
  stands_still_ = !left_out.lines.empty();
  if (left_out.hands == 0 || !frame.hands.empty() || !cleaner_) return false;
  // Also once the hand is gone: the array is silent because nobody is there, not because of age.
  releaseHeld();
  return true;
}

// Of a live source, which may never send a sample, `~duration` runs from the first one on.
bool HandTracking::over() const {
  return duration_ > 0.0 && first_sample_ && (ros::SteadyTime::now() - *first_sample_).toSec() >= duration_;
}

// Waits until the sample is due. Nothing where `~duration` is over.
std::optional<std::chrono::nanoseconds> HandTracking::recordingStamp(const hand::TrackedFrame& frame) {
  const auto stamp = time_(frame.stamp);
  if (time_.repaired() > repaired_stamps_) {
    repaired_stamps_ = time_.repaired();
    ROS_WARN_THROTTLE(5.0, "hand_tracking: stamp %.6f s does not follow the one before: taken as %.6f s",
                      1e-9 * static_cast<double>(frame.stamp.count()),
                      1e-9 * static_cast<double>(stamp.count()));
  }
  if (!first_stamp_) first_stamp_ = stamp;
  const auto elapsed = stamp - *first_stamp_;
  if (duration_ > 0.0 && std::chrono::duration<double>(elapsed).count() >= duration_) return std::nullopt;
  if (lockstep_) return stamp;
  pace(elapsed);
  return toCore(ros::Time::now());
}

std::chrono::nanoseconds HandTracking::liveStamp(const hand::TrackedFrame& frame) {
  using std::chrono::steady_clock;
  if (!first_sample_) first_sample_ = ros::SteadyTime::now();
  const steady_clock::time_point now = steady_clock::now();
  const bool told = frame.received != steady_clock::time_point();
  const auto sampled = clock_(frame.stamp, (told ? frame.received : now).time_since_epoch());
  clock_restarts_ = clock_.restarts();
  const auto ros_now = toCore(ros::Time::now());
  // Simulated time may stand still or run at any speed: it is then the time of arrival.
  const auto stamp = ros::Time::isSimTime() ? ros_now : ros_now - (now.time_since_epoch() - sampled);
  return std::max(stamp, last_stamp_ + std::chrono::microseconds(1));
}

// A tracker that says nothing does not leave its hands in the clay.
void HandTracking::holdHands() {
  if (!is_live_ || passes_by_ || !cleaner_ || !cleaner_->present()) return;
  releaseHeld();
}

// A frame of now in which no hand was seen.
void HandTracking::releaseHeld() {
  hand::TrackedFrame frame;
  frame.stamp = std::max(toCore(ros::Time::now()), last_stamp_ + std::chrono::microseconds(1));
  frame.frame_id = source_frame_;
  {
    const std::lock_guard<std::mutex> lock(report_mutex_);
    cleaner_->hold(frame);
    counts_ = cleaner_->counts();
  }
  placeInWorld(frame, world_, transforms_);
  release(frame);
}

void HandTracking::clean(hand::TrackedFrame& frame) {
  if (live_) live_->begin(toRos(frame.stamp));
  const std::lock_guard<std::mutex> lock(report_mutex_);
  for (const hand::TrackedHand& hand : frame.hands) {
    auto& least = report_.confidence[static_cast<int>(hand.side)];
    least = std::min(least.value_or(1.0), hand.confidence);
  }
  if (!cleaner_) {
    bad_hands_ += static_cast<unsigned>(hand::keepOneHandASide(frame.hands));
    return;
  }
  const std::uint64_t jumps = counts_.jumps;
  cleaner_->clean(frame);
  counts_ = cleaner_->counts();
  if (counts_.jumps > jumps)
    ROS_WARN_THROTTLE(1.0,
                      "hand_tracking: the palm of a hand jumped, expected at most 20 m/s, and %g m under a "
                      "new id; it is taken for "
                      "another hand",
                      hand::CleanConfig().same_hand_distance);
}

void HandTracking::tellFault() {
  const std::string fault = oneLine(source_->takeFault());
  if (fault.empty()) return;
  ++faults_;
  ROS_WARN_THROTTLE(5.0, "hand_tracking: %s", fault.c_str());
  const std::lock_guard<std::mutex> lock(report_mutex_);
  report_.fault = fault;
}

void HandTracking::pace(std::chrono::nanoseconds elapsed) {
  const ros::SteadyTime due =
      start_ + ros::WallDuration(std::chrono::duration<double>(elapsed).count() / rate_);
  for (auto left = due - ros::SteadyTime::now(); left > ros::WallDuration(0.0) && !stopped();
       left = due - ros::SteadyTime::now())
    std::min(left, ros::WallDuration(0.1)).sleep();
}

void HandTracking::release(const hand::TrackedFrame& frame) {
  tellStandingClock();
  const ros::Time stamp = toRos(frame.stamp);
  if (publisher_) publisher_.publish(boost::make_shared<TrackedHands>(toMessage(frame)));
  last_release_ = stamp;
  last_stamp_ = frame.stamp;
  ++frames_;
  {
    const std::lock_guard<std::mutex> lock(report_mutex_);
    const double age = lockstep_ ? 0.0 : secondsBetween(stamp, ros::Time::now());
    ++report_.frames;
    report_.age_sum += age;
    report_.age_max = std::max(report_.age_max, age);
  }
  hands_ = static_cast<unsigned>(frame.hands.size());
  if (!lockstep_) return;
  if (!answers_.wait(stamp, answer_patience_, [this] { return stopped(); }) && !stopped())
    throw std::runtime_error("lockstep: no answer on " + nh_.resolveName(topic::array_state) + " to frame " +
                             std::to_string(frames_) + " within " + seconds(answer_patience_) + ": " +
                             chain_->whereIs(stamp));
}

void HandTracking::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const ros::WallTime now = ros::WallTime::now();
  const double seconds = reported_.isZero() ? 1.0 : std::max(1e-3, (now - reported_).toSec());
  reported_ = now;
  const std::lock_guard<std::mutex> lock(report_mutex_);
  const Report report = std::exchange(report_, Report());
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (!report.fault.empty())
    status.summary(Level::WARN, report.fault);
  else if (report.frames == 0)
    status.summary(is_live_ ? Level::ERROR : Level::WARN, "no frames from source '" + source_name_ + "'");
  else if (stands_still_)
    status.summary(Level::WARN, "the tracker stands still: it repeats its hands");
  else if (bad_hands_ > 0 || bad_fingers_ > 0 || repaired_stamps_ > 0)
    status.summary(Level::WARN, "hands or fingers left out, or stamps repaired");
  else
    status.summary(Level::OK, "tracking");
  status.add("source", source_name_);
  status.add("frames", frames_.load());
  status.add("rate, Hz", report.frames / seconds);
  status.add("age, mean, s", report.frames > 0 ? report.age_sum / report.frames : 0.0);
  status.add("age, most, s", report.age_max);
  status.add("hands", hands_.load());
  for (const int side : {0, 1})
    status.add(side == 0 ? "confidence, left, least" : "confidence, right, least",
               report.confidence[side] ? std::to_string(*report.confidence[side]) : "not seen");
  status.add("dropouts", counts_.dropouts);
  status.add("hands lost", counts_.losses);
  status.add("changes of id", counts_.id_changes);
  status.add("changes of side", counts_.side_changes);
  status.add("artefacts left out", counts_.artefacts);
  status.add("jumps", counts_.jumps);
  status.add("second hands of a side", counts_.doubles);
  status.add("hands left out", bad_hands_.load());
  status.add("fingers left out", bad_fingers_.load());
  status.add("hands only repeated", repeated_hands_.load());
  status.add("stamps repaired", repaired_stamps_.load());
  status.add("restarts of the device clock", clock_restarts_.load());
  status.add("faults of the source", faults_.load());
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
