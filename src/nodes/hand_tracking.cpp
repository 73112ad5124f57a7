#include "nodes/hand_tracking.h"

#include <tactile_clay/TrackedHands.h>

#include <algorithm>
#include <stdexcept>

#include "nodes/conversions.h"
#include "nodes/exit_code.h"
#include "nodes/graph_connections.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration answer_patience(30.0);  // lockstep
const ros::WallDuration graph_patience(15.0);   // live
const std::vector<std::string> whole_graph = {topic::hands_tracked, topic::hands_skin,
                                              topic::clay_contacts, topic::hands_pressure,
                                              topic::focal_points,  topic::array_state};
const std::vector<std::string> side_topics = {topic::clay_particles, topic::clay_status,
                                              topic::joint_states,   topic::array_drive,
                                              topic::array_measured, topic::array_field};

}  // namespace

HandTracking::HandTracking(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : nh_(nh),
      source_name_(param<std::string>(private_nh, "source", "bag")),
      world_(param<std::string>(private_nh, "world_frame", frame::world)),
      rate_(paramIn(private_nh, "rate", 1.0, 0.01, 100.0)),
      duration_(paramIn(private_nh, "duration", 0.0, 0.0, 1e9)),
      lockstep_(param(private_nh, "lockstep", false)),
      source_("tactile_clay::hand::HandSource", "source of hands", source_name_),
      answers_(nh),
      health_(nh, private_nh, "tracked hands", [this](auto& status) { diagnose(status); }) {
  static_transforms_->send(transformMessage(
      world_, frame::tracker, poseParam(private_nh, "tracker_pose", "0 0 0 0 0 0"), ros::Time::now()));

  hand::SourceOptions options;
  options.file = param<std::string>(private_nh, "file", "");
  options.url = param<std::string>(private_nh, "url", "");
  options.topic = param<std::string>(private_nh, "topic", topic::hands_tracked);
  options.loop = param(private_nh, "loop", false);
  const bool from_topic = source_name_ == "topic";
  if (from_topic) options.topic = nh.resolveName(options.topic);
  passes_by_ = from_topic && options.topic == nh.resolveName(topic::hands_tracked);
  source_->open(options);
  if (lockstep_ && !source_->recorded())
    throw std::runtime_error("lockstep: expected hands from a recording or none, got the live source '" +
                             source_name_ + "'");

  wait_for_graph_ = param(private_nh, "wait_for_graph", false) || lockstep_;
  for (const std::string& name : param(private_nh, "graph", whole_graph))
    graph_.required.push_back(nh.resolveName(name));
  for (const std::string& name : side_topics) graph_.optional.push_back(nh.resolveName(name));
  const auto recorder = param<std::string>(private_nh, "recorder", "");
  if (!recorder.empty()) graph_.recorder = nh.resolveName(recorder);
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
    if (lockstep_ && now - start > answer_patience)
      throw std::runtime_error("lockstep: the graph is not connected after 30 s: " + missing);
    if (!lockstep_ && now - start > graph_patience) {
      ROS_WARN("hand_tracking: starts although the graph is not connected: %s", missing.c_str());
      return;
    }
    ros::WallDuration(0.05).sleep();
  }
}

void HandTracking::follow() {
  std::chrono::nanoseconds first{-1};
  while (!stopped()) {
    hand::TrackedFrame frame;
    const Read read = source_->read(frame, std::chrono::milliseconds(100));
    if (read == Read::ended) return;
    if (read == Read::nothing) continue;

    const auto stamp = time_(frame.stamp);
    if (time_.repaired() > repaired_stamps_) {
      repaired_stamps_ = time_.repaired();
      ROS_WARN_THROTTLE(5.0, "hand_tracking: stamp %.6f s does not follow the one before: taken as %.6f s",
                        1e-9 * static_cast<double>(frame.stamp.count()),
                        1e-9 * static_cast<double>(stamp.count()));
    }
    if (first.count() < 0) first = stamp;
    if (duration_ > 0.0 && std::chrono::duration<double>(stamp - first).count() >= duration_) return;
    if (!lockstep_ && source_->recorded()) pace(stamp - first);
    if (stopped()) return;
    bad_hands_ += static_cast<unsigned>(leaveOutBadHands(frame));
    placeInWorld(frame, world_, transforms_);
    frame.stamp = lockstep_ ? stamp : toCore(ros::Time::now());
    release(frame);
  }
}

void HandTracking::pace(std::chrono::nanoseconds elapsed) {
  const ros::SteadyTime due =
      start_ + ros::WallDuration(std::chrono::duration<double>(elapsed).count() / rate_);
  for (auto left = due - ros::SteadyTime::now(); left > ros::WallDuration(0.0) && !stopped();
       left = due - ros::SteadyTime::now())
    std::min(left, ros::WallDuration(0.1)).sleep();
}

void HandTracking::release(const hand::TrackedFrame& frame) {
  const ros::Time stamp = toRos(frame.stamp);
  if (publisher_) publisher_.publish(boost::make_shared<TrackedHands>(toMessage(frame)));
  last_release_ = stamp;
  ++frames_;
  hands_ = static_cast<unsigned>(frame.hands.size());
  if (!lockstep_) return;
  if (!answers_.wait(stamp, answer_patience, [this] { return stopped(); }) && !stopped())
    throw std::runtime_error("lockstep: no answer on " + nh_.resolveName(topic::array_state) + " to frame " +
                             std::to_string(frames_) + " within 30 s");
}

void HandTracking::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const unsigned frames = frames_;
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (frames == frames_before_) {
    status.summary(Level::WARN, "no frames from source '" + source_name_ + "'");
  } else if (bad_hands_ > 0 || repaired_stamps_ > 0) {
    status.summary(Level::WARN, "hands left out or stamps repaired");
  } else {
    status.summary(Level::OK, "tracking");
  }
  status.add("source", source_name_);
  status.add("frames", frames);
  status.add("frames a second", frames - frames_before_);
  status.add("hands", hands_.load());
  status.add("hands left out", bad_hands_.load());
  status.add("stamps repaired", repaired_stamps_.load());
  frames_before_ = frames;
}

}  // namespace tactile_clay::nodes
