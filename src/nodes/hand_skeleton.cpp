#include "nodes/hand_skeleton.h"

#include <sensor_msgs/JointState.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>

#include "hand/hand_check.h"
#include "hand/hand_sides.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr std::size_t samples_to_measure = 30;
constexpr double sure = 0.5;         // minimum confidence of a sample that a person is measured from
constexpr double other_size = 0.01;  // m of mean error, above which this is another person's hand

std::string name(hand::Side side) {
  return side == hand::Side::left ? "left" : "right";
}

// The name has no namespace part. rviz looks parameters up with searchParam. If only the namespace of a
// parameter exists, that search reports the parameter as found, and its value is empty.
std::string description(hand::Side side) {
  return "hand_" + name(side) + "_description";
}

std::set<std::string> jointsOf(hand::Side side) {
  std::set<std::string> names;
  for (int k = 0; k < hand::skeleton_joint_count; ++k) names.insert(hand::skeletonJointName(side, k));
  return names;
}

}  // namespace

HandSkeleton::HandSkeleton(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : nh_(nh),
      world_(frameName(param<std::string>(private_nh, "world_frame", frame::world))),
      inbox_(private_nh),
      left_joints_(nh, inbox_, topic::joint_states_left, jointsOf(hand::Side::left)),
      right_joints_(nh, inbox_, topic::joint_states_right, jointsOf(hand::Side::right)),
      health_(nh, private_nh, "hand skeleton", [this](auto& status) { diagnose(status); }) {
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 1;
  forgetModels();  // models of an earlier run
  for (const hand::Side side : {hand::Side::left, hand::Side::right})
    sides_[static_cast<int>(side)].publisher = nh.advertise<sensor_msgs::JointState>(
        side == hand::Side::left ? topic::joint_states_left : topic::joint_states_right, queue);
  subscriber_ = inbox_.subscribe<TrackedHands>(nh, topic::hands_tracked, queue,
                                               [this](const auto& message) { receive(*message); });
}

HandSkeleton::~HandSkeleton() {
  forgetModels();
}

void HandSkeleton::forgetModels() {
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) nh_.deleteParam(description(side));
}

void HandSkeleton::receive(const TrackedHands& message) {
  hand::TrackedFrame frame = toCore(message);
  leaveOutBadHands(frame);
  hand::keepOneHandASide(frame.hands);
  placeInWorld(frame, world_, transforms_);
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
    const auto tracked = std::find_if(frame.hands.begin(), frame.hands.end(),
                                      [side](const hand::TrackedHand& h) { return h.side == side; });
    follow(side, tracked == frame.hands.end() ? nullptr : &*tracked, message.header.stamp);
  }
}

void HandSkeleton::follow(hand::Side side, const hand::TrackedHand* tracked, const ros::Time& stamp) {
  State& state = sides_[static_cast<int>(side)];
  if (!tracked) {
    if (state.pose) sendWrist(side, "hand_" + name(side) + "_lost", Eigen::Isometry3d::Identity(), stamp);
    state.pose.reset();
    return;
  }
  if (!state.skeleton) measure(state, *tracked);
  if (!state.skeleton) return;
  const hand::SkeletonFit fit =
      hand::fitSkeleton(*state.skeleton, *tracked, state.pose ? &*state.pose : nullptr);
  state.pose = fit.pose;
  state.error_sum +=
      std::accumulate(fit.error.begin(), fit.error.end(), 0.0) / static_cast<double>(fit.error.size());
  ++state.frames;
  sendWrist(side, world_, fit.pose.wrist, stamp);
  sensor_msgs::JointState joints;
  joints.header.stamp = stamp;
  for (int k = 0; k < hand::skeleton_joint_count; ++k)
    joints.name.push_back(hand::skeletonJointName(side, k));
  joints.position.assign(fit.pose.angles.begin(), fit.pose.angles.end());
  state.publisher.publish(joints);
}

void HandSkeleton::measure(State& state, const hand::TrackedHand& tracked) {
  if (tracked.confidence < sure || tracked.missing.any()) return;
  state.samples.push_back(tracked);
  if (state.samples.size() < samples_to_measure) return;
  try {
    state.skeleton = hand::measureSkeleton(state.samples);
    nh_.setParam(description(tracked.side), hand::skeletonUrdf(*state.skeleton));
  } catch (const std::invalid_argument& error) {
    ROS_WARN_THROTTLE(5.0, "hand_skeleton: the %s hand is not measured: %s", name(tracked.side).c_str(),
                      error.what());
  }
  state.samples.clear();
}

void HandSkeleton::sendWrist(hand::Side side, const std::string& parent, const Eigen::Isometry3d& pose,
                             const ros::Time& stamp) {
  broadcaster_.send(transformMessage(parent, "hand_" + name(side) + "_wrist", pose, stamp));
}

void HandSkeleton::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  status.summary(Level::OK, "following");
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
    State& state = sides_[static_cast<int>(side)];
    const std::string hand = name(side) + " hand";
    status.add(hand, !state.skeleton ? "not measured yet" : state.pose ? "seen" : "not seen");
    if (state.skeleton) status.add(hand + ", size over that of an adult", state.skeleton->scale);
    if (state.frames == 0) continue;
    const double error = state.error_sum / state.frames;
    status.add(hand + ", mean error of its joints, mm", 1e3 * error);
    if (error > other_size)
      status.summary(Level::WARN, "the " + hand + " is not the one that was measured: start the rig again");
    state.error_sum = 0.0;
    state.frames = 0;
  }
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
