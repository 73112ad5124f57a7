#include "nodes/hand_tracking.h"

#include <tactile_clay/TrackedHands.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "hand/hand_check.h"
#include "hand/hand_sides.h"
#include "nodes/clean_parameters.h"
#include "nodes/conversions.h"
#include "nodes/exit_code.h"
#include "nodes/frame_name.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/topics.h"
#include "safety/silence_times.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

constexpr std::chrono::milliseconds live_patience = silence_times::tracker_silent;
constexpr std::chrono::milliseconds recording_patience(100);

}  // namespace

LiveParameters::Apply HandTracking::read(Settings& settings) {
  const hand::CleanConfig config = cleanConfig(settings);
  return [this, config] {
    const std::lock_guard<std::mutex> lock(report_mutex_);
    cleaner_->configure(config);
  };
}

HandTracking::HandTracking(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : source_name_(param<std::string>(private_nh, "source", "bag")),
      world_(frameName(param<std::string>(private_nh, "world_frame", frame::world))),
      source_("tactile_clay::hand::HandSource", "source of hands", source_name_),
      inbox_(private_nh),
      pace_(nh, private_nh, inbox_, [this] { return stopped(); }),
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
  cleanConfig(filters);  // throws if a filter is wrong, also if none is used
  source_->open(options);
  is_live_ = !source_->recorded();
  if (wanted == "true" || (wanted == "auto" && !source_->cleaned())) {
    cleaner_.emplace(hand::CleanConfig());
    live_ = std::make_unique<LiveParameters>(nh, private_nh,
                                             [this](Settings& settings) { return read(settings); });
  }
  // A cleaner itself bridges hands that are not seen anew.
  repeats_.emplace(cleaner_ ? std::chrono::nanoseconds(0) : repeats_patience);
  if (pace_.lockstep() && !source_->recorded())
    throw std::runtime_error("lockstep: expected hands from a recording or none, got the live source '" +
                             source_name_ + "'");

  if (!passes_by_) publisher_ = nh.advertise<TrackedHands>(topic::hands_tracked, pace_.lockstep() ? 0 : 1);
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
  if (!pace_.lockstep() && source_name_ != "topic") waitForClock([this] { return stopped(); });
  pace_.start(source_->recorded());
  follow();
  if (stopped()) return;
  if (!passes_by_ && frames_ > 0) pace_.awaitLastAnswer(last_release_);
  // Recorders and displays get the last messages before the process ends.
  ros::WallDuration(0.3).sleep();
  ROS_INFO("hand_tracking: the input ended after %u frames", frames_.load());
  finish(0);
}

void HandTracking::follow() {
  while (!stopped() && !pace_.over()) {
    hand::TrackedFrame frame;
    const Read read = source_->read(frame, is_live_ ? live_patience : recording_patience);
    tellFault();
    if (read == Read::ended) return;
    if (read == Read::nothing) {
      holdHands();
      continue;
    }
    if (is_live_ && leaveOutRepeats(frame)) continue;
    if (!isDue(frame) || stopped()) return;
    source_frame_ = frame.frame_id;
    const hand::LeftOut left_out = leaveOutBadHands(frame);
    bad_hands_ += static_cast<unsigned>(left_out.hands);
    bad_fingers_ += static_cast<unsigned>(left_out.fingers);
    clean(frame);
    placeInWorld(frame, world_, transforms_);
    release(frame);
  }
}

// Sets the stamp of a sample; waits until a sample of a recording is due. Returns false if `~duration` is
// over.
bool HandTracking::isDue(hand::TrackedFrame& frame) {
  if (is_live_) {
    pace_.sampled();
    frame.stamp = clock_.ofLive(frame);
    return true;
  }
  const std::chrono::nanoseconds recorded = clock_.ofRecording(frame);
  const std::optional<std::chrono::nanoseconds> late = pace_.due(recorded);
  if (!late) return false;
  frame.stamp = pace_.lockstep() ? recorded : clock_.ofPlayed(*late);
  return true;
}

// A hand that a live tracker only repeats counts as not seen. If the frame has no other hand and there is a
// cleaner, releases a frame with the present time instead and returns true: the caller then skips this frame.
bool HandTracking::leaveOutRepeats(hand::TrackedFrame& frame) {
  // If the input is hands/tracked itself, hand_simulator leaves repeated hands out.
  if (passes_by_ || frame.played) return false;
  const std::chrono::nanoseconds now = std::chrono::steady_clock::now().time_since_epoch();
  const hand::LeftOut left_out = repeats_->leaveOutRepeats(frame.hands, now);
  repeated_hands_ += static_cast<unsigned>(left_out.hands);
  tell(left_out);
  stands_still_ = !left_out.lines.empty();
  if (left_out.hands == 0 || !frame.hands.empty() || !cleaner_) return false;
  // Also when the hand is gone: the array is then silent because no hand is there, not because of the age of
  // the hands.
  releaseHeld();
  return true;
}

// If a live tracker sends nothing, its hands must not stay in the clay.
void HandTracking::holdHands() {
  if (!is_live_ || passes_by_ || !cleaner_ || !cleaner_->present()) return;
  releaseHeld();
}

// Releases a frame with the present time in which no hand was seen; the cleaner holds its hands or fades them
// out.
void HandTracking::releaseHeld() {
  hand::TrackedFrame frame;
  frame.stamp = clock_.next();
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
    auto& minimum = report_.confidence[static_cast<int>(hand.side)];
    minimum = std::min(minimum.value_or(1.0), hand.confidence);
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
                      "hand_tracking: the palm of a hand jumped, so it is taken for another hand; expected "
                      "at most 20 m/s, and %g m with a new id",
                      hand::CleanConfig().same_hand_distance);
}

void HandTracking::tellFault() {
  const std::string fault = values::printableLine(source_->takeFault());
  if (fault.empty()) return;
  ++faults_;
  ROS_WARN_THROTTLE(5.0, "hand_tracking: %s", fault.c_str());
  const std::lock_guard<std::mutex> lock(report_mutex_);
  report_.fault = fault;
}

void HandTracking::release(const hand::TrackedFrame& frame) {
  if (!pace_.lockstep()) clock_.tellStanding();
  const ros::Time stamp = toRos(frame.stamp);
  if (publisher_) publisher_.publish(boost::make_shared<TrackedHands>(toMessage(frame)));
  last_release_ = stamp;
  clock_.released(frame.stamp);
  ++frames_;
  {
    const std::lock_guard<std::mutex> lock(report_mutex_);
    const double age = pace_.lockstep() ? 0.0 : secondsBetween(stamp, ros::Time::now());
    ++report_.frames;
    report_.age_sum += age;
    report_.age_max = std::max(report_.age_max, age);
  }
  hands_ = static_cast<unsigned>(frame.hands.size());
  pace_.awaitAnswer(stamp, frames_);
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
    status.summary(Level::WARN, "the tracker is frozen: it repeats its hands");
  else if (bad_hands_ > 0 || bad_fingers_ > 0 || clock_.repaired() > 0)
    status.summary(Level::WARN, "hands or fingers left out, or stamps repaired");
  else
    status.summary(Level::OK, "tracking");
  status.add("source", source_name_);
  status.add("frames", frames_.load());
  status.add("rate, Hz", report.frames / seconds);
  status.add("age, mean, s", report.frames > 0 ? report.age_sum / report.frames : 0.0);
  status.add("age, maximum, s", report.age_max);
  status.add("hands", hands_.load());
  for (const int side : {0, 1})
    status.add(side == 0 ? "confidence, left, minimum" : "confidence, right, minimum",
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
  status.add("hands repeated", repeated_hands_.load());
  status.add("stamps repaired", clock_.repaired());
  status.add("restarts of the device clock", clock_.restarts());
  status.add("faults of the source", faults_.load());
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
