#include "hand/speed_limit.h"

#include <algorithm>

#include "hand/anatomy.h"
#include "values/seconds.h"

namespace tactile_clay::hand {
namespace {

using values::seconds;

constexpr double faster = 1.15;    // than the tracker has shown
constexpr double no_leap = 1e-4;   // m; less than the noise of a tracker
constexpr double forgotten = 1.0;  // s; what a joint did before it was unseen for longer tells nothing

double distance(const JointPose& a, const JointPose& b) {
  return (a.position - b.position).norm();
}

}  // namespace

void SpeedLimit::see(const TrackedHand& hand, Time stamp) {
  for (int k = 0; k < joint_count; ++k) {
    if (hand.missing[k]) continue;
    Joint& joint = joints_[k];
    if (joint.seen) {
      const double dt = seconds(stamp - joint.seen->stamp);
      if (dt > forgotten) joint.fastest = 0.0;
      joint.fastest = std::max(joint.fastest, distance(hand.joints[k], joint.seen->pose) / dt);
    }
    joint.seen = {hand.joints[k], stamp};
  }
}

double SpeedLimit::share(const TrackedHand& goal, Time stamp) const {
  double share = 1.0;
  for (int k = 0; k < joint_count; ++k) {
    if (goal.missing[k] || !wasShown(k)) continue;
    const double step = distance(goal.joints[k], joints_[k].shown->pose),
                 farthest = faster * joints_[k].fastest * seconds(stamp - *last_);
    if (step > farthest) share = std::min(share, farthest / step);
  }
  return share;
}

bool SpeedLimit::couldCome(int k, const JointPose& pose, Time stamp) const {
  const Joint& joint = joints_[k];
  return !joint.shown || distance(pose, joint.shown->pose) <=
                             faster * joint.fastest * seconds(stamp - joint.shown->stamp) + no_leap;
}

void SpeedLimit::approach(TrackedHand& hand, Time stamp) const {
  const double part = share(hand, stamp);
  if (part >= 1.0) return;
  const Eigen::Vector3d goal = hand.joints[palm].position;
  for (int k = 0; k < joint_count; ++k) {
    if (!wasShown(k)) continue;
    const JointPose& from = joints_[k].shown->pose;
    JointPose& pose = hand.joints[k];
    pose.position = from.position + part * (pose.position - from.position);
    pose.orientation = from.orientation.slerp(part, pose.orientation);
  }
  // Joints that come back are as far behind as the palm is.
  const Eigen::Vector3d behind = hand.joints[palm].position - goal;
  for (int k = 0; k < joint_count; ++k)
    if (!wasShown(k)) hand.joints[k].position += behind;
}

bool SpeedLimit::leaveOut(TrackedHand& hand, bool seen, Time stamp) const {
  const auto leaps = [&](int k) {
    return !hand.missing[k] && !wasShown(k) && !(seen && couldCome(k, hand.joints[k], stamp));
  };
  if (leaps(palm) || leaps(wrist)) return false;
  for (const FingerJoints& finger : fingers) {
    bool leap = false;
    for (int i = 0; i < finger.count; ++i) leap = leap || leaps(finger[i]);
    for (int i = 0; i < finger.count && leap; ++i)
      if (!wasShown(finger[i])) hand.missing.set(finger[i]);
  }
  return fingersLeft(hand) >= min_fingers;
}

std::optional<TrackedHand> SpeedLimit::step(const TrackedHand* seen, const TrackedHand* goal, Time stamp) {
  if (seen != nullptr) see(*seen, stamp);
  std::optional<TrackedHand> hand;
  if (goal != nullptr) {
    hand = *goal;
    approach(*hand, stamp);
    if (!leaveOut(*hand, seen != nullptr, stamp)) hand.reset();
  }
  last_ = stamp;
  for (int k = 0; hand && k < joint_count; ++k)
    if (!hand->missing[k]) joints_[k].shown = {hand->joints[k], stamp};
  return hand;
}

}  // namespace tactile_clay::hand
