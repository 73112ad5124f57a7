#include "nodes/release_pace.h"

#include <std_msgs/Header.h>
#include <tactile_clay/ArrayState.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration graph_patience(15.0);  // s, live
constexpr std::size_t max_unrecorded = 16;     // samples: enough to keep the recorder busy
const std::vector<std::string> whole_graph = {topic::hands_tracked, topic::hands_skin,
                                              topic::clay_contacts, topic::hands_pressure,
                                              topic::focal_points,  topic::array_state};
const std::vector<std::string> side_topics = {
    topic::clay_particles,    topic::clay_status,        topic::joint_states, topic::array_drive,
    topic::array_measured,    topic::array_field,        topic::rendering,    topic::acoustics,
    topic::joint_states_left, topic::joint_states_right, topic::hands_bones,  topic::changes};

std::string seconds(const ros::WallDuration& duration) {
  std::ostringstream text;
  text << duration.toSec() << " s";
  return text.str();
}

}  // namespace

ReleasePace::ReleasePace(ros::NodeHandle nh, const ros::NodeHandle& private_nh, Inbox& inbox,
                         std::function<bool()> stopped)
    : nh_(nh),
      stopped_(std::move(stopped)),
      rate_(paramIn(private_nh, "rate", 1.0, 0.01, 100.0)),
      duration_(paramIn(private_nh, "duration", 0.0, 0.0, 1e9)),
      lockstep_(param(private_nh, "lockstep", false)),
      answer_patience_(paramIn(private_nh, "answer_patience", 30.0, 0.1, 1e6)),
      wait_for_graph_(param(private_nh, "wait_for_graph", false) || lockstep_),
      state_subscriber_(inbox.subscribe<ArrayState>(
          nh, topic::array_state, 0, [this](const auto& state) { answers_.add(state->header.stamp); })) {
  for (const std::string& name : param(private_nh, "graph", whole_graph))
    graph_.required.push_back(nh.resolveName(name));
  for (const std::string& name : side_topics) graph_.optional.push_back(nh.resolveName(name));
  if (lockstep_) chain_.emplace(nh, graph_.required);
  const auto recorder = param<std::string>(private_nh, "recorder", "");
  if (!recorder.empty()) graph_.recorder = nh.resolveName(recorder);
  if (lockstep_)
    recorded_subscriber_ = inbox.subscribe<std_msgs::Header>(
        nh, topic::recorded, 0, [this](const auto& header) { recorded_.add(header->stamp); });
  for (const std::string& name : param(private_nh, "unrecorded", std::vector<std::string>()))
    graph_.unrecorded.push_back(nh.resolveName(name));
  for (const std::string& name : param(private_nh, "recorded_first", std::vector<std::string>()))
    graph_.required.push_back(nh.resolveName(name));
}

void ReleasePace::start(bool recorded) {
  if (wait_for_graph_ && recorded) waitForGraph();
  start_ = ros::SteadyTime::now();
}

void ReleasePace::waitForGraph() {
  const ros::WallTime start = ros::WallTime::now();
  const ros::WallDuration settled(0.3);  // a node that is connected may still be in its constructor
  ros::WallTime connected_since;
  while (!stopped_()) {
    const std::string missing = missingConnection(graph_);
    const ros::WallTime now = ros::WallTime::now();
    if (!missing.empty()) connected_since = ros::WallTime();
    if (missing.empty() && connected_since.isZero()) connected_since = now;
    if (missing.empty() && now - connected_since >= settled) return;
    if (lockstep_ && now - start > answer_patience_)
      throw std::runtime_error("lockstep: the graph is not connected after " + seconds(answer_patience_) +
                               ": " + missing);
    if (!lockstep_ && now - start > graph_patience) {
      ROS_WARN("hand_tracking: starts, although the graph is not connected: %s", missing.c_str());
      return;
    }
    ros::WallDuration(0.05).sleep();
  }
}

std::optional<std::chrono::nanoseconds> ReleasePace::due(std::chrono::nanoseconds stamp) {
  if (!first_stamp_) first_stamp_ = stamp;
  const double elapsed = std::chrono::duration<double>(stamp - *first_stamp_).count();  // s
  if (duration_ > 0.0 && elapsed >= duration_) return std::nullopt;
  std::chrono::nanoseconds late(0);
  if (lockstep_) return late;
  const ros::SteadyTime due = start_ + ros::WallDuration(elapsed / rate_);
  for (auto left = due - ros::SteadyTime::now(); left > ros::WallDuration(0.0) && !stopped_();
       left = due - ros::SteadyTime::now())
    std::min(left, ros::WallDuration(0.1)).sleep();
  late = std::chrono::nanoseconds((ros::SteadyTime::now() - due).toNSec());
  return std::max(late, std::chrono::nanoseconds(0));
}

void ReleasePace::sampled() {
  if (!first_sample_) first_sample_ = ros::SteadyTime::now();
}

bool ReleasePace::over() const {
  return duration_ > 0.0 && first_sample_ && (ros::SteadyTime::now() - *first_sample_).toSec() >= duration_;
}

void ReleasePace::awaitAnswer(const ros::Time& stamp, unsigned frame) {
  if (!lockstep_) return;
  if (!answers_.wait(stamp, answer_patience_, stopped_) && !stopped_())
    throw std::runtime_error("lockstep: no answer on " + nh_.resolveName(topic::array_state) + " to frame " +
                             std::to_string(frame) + " within " + seconds(answer_patience_) + ": " +
                             chain_->whereIs(stamp));
  unrecorded_.push_back(stamp);
  for (; unrecorded_.size() > max_unrecorded; unrecorded_.pop_front()) awaitRecorder(unrecorded_.front());
}

void ReleasePace::awaitLastAnswer(const ros::Time& stamp) {
  if (lockstep_)
    awaitRecorder(stamp);
  else
    answers_.wait(stamp, ros::WallDuration(2.0), stopped_);
}

/// A recorder that does not publish what it has written, such as `rosbag record`, is not waited for.
void ReleasePace::awaitRecorder(const ros::Time& stamp) {
  if (recorded_subscriber_.getNumPublishers() == 0) return;
  if (!recorded_.wait(stamp, answer_patience_, stopped_) && !stopped_())
    throw std::runtime_error("lockstep: " + nh_.resolveName(topic::recorded) + " does not confirm within " +
                             seconds(answer_patience_) + " that a sample is in the bag");
}

}  // namespace tactile_clay::nodes
