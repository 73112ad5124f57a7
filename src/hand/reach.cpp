#include "hand/reach.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "hand/anatomy.h"
#include "hand/capsule.h"
#include "hand/hand_bodies.h"
#include "hand/hand_pose.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// rad, how far a bone may turn from the middle of its reach: the thumb's metacarpal, any other bone. In six
// recordings they turn by up to 46 and 74 degrees. A little farther in the palm a thumb's flesh has no room.
constexpr double thumb_root_reach = 46.0 * degree, joint_reach = 75.0 * degree;
constexpr double twist_reach = 30.0 * degree;  // rad, about the bone's own axis
// Allowed differences of hands in their proportions, at scale 1: m, of the root of the thumb and of a finger
// from its place in the palm; lengths of bones. Tracked hands reach 11 mm, 4.4 mm, and 0.87 to 1.14.
constexpr double thumb_root_off = 0.014, finger_root_off = 0.006, shortest = 0.8, longest = 1.25;
// m, at scale 1, from the middle of the thumb's metacarpal to the index finger's; tracked hands reach 20 mm.
constexpr double thumb_closest = 0.018;

TrackedHand middleOfReach(Side side) {
  HandPose pose;
  pose.side = side;
  for (FingerAngles& finger : pose.fingers) finger.flexion.fill(0.47);
  pose.fingers[0].flexion = {0.05, 0.0, 0.0};
  pose.fingers[0].abduction = 0.5;
  return forwardKinematics(pose);
}

/// A hand with every bone in the middle of its reach.
struct Middle {
  TrackedHand hand;
  Vector3d palm_centre;  // m

  explicit Middle(Side side) : hand(middleOfReach(side)), palm_centre(bodyCentres(hand)[palm_body]) {}
  static const Middle& of(Side side) {
    static const std::array<Middle, 2> middles = {Middle(Side::left), Middle(Side::right)};
    return middles[static_cast<int>(side)];
  }
};

/// A tracked hand whose fingers are moved into their reach.
class LedHand {
 public:
  explicit LedHand(const TrackedHand& tracked)
      : scale_(handScale(tracked)), hand_(tracked), poses_(bodyPoses(tracked, middle().hand)) {}

  /// How far a finger's proportions are from those of any person. Up to 1 it may be a person's.
  double strangeness(int finger) const {
    const int root = rootOf(finger);
    double stretch = 0.0;
    for (const int b : bodiesOf(finger)) {
      const double logarithm = std::log(std::max(1e-9, bone(b).norm()) / usualLength(b));
      stretch = std::max(stretch, logarithm / std::log(logarithm < 0.0 ? shortest : longest));
    }
    const double proportions = std::hypot((at(root) - usualPlace(root)).norm() / rootOff(finger), stretch);
    return root == thumb_metacarpal ? std::max(proportions, closeness()) : proportions;
  }

  void rest(int finger) {
    for (int j = fingers[finger].first; j <= fingers[finger].tip(); ++j) {
      at(j) = usualPlace(j);
      hand_.joints[j].orientation = poses_[palm_body].rotation * middle().hand.joints[j].orientation;
    }
  }

  /// @param room share of the reach that the finger has
  void lead(int finger, double room) {
    const int root = rootOf(finger), first = fingers[finger].first;
    const Vector3d off = at(root) - usualPlace(root);
    if (off.norm() > room * rootOff(finger))
      move(finger, root, (room * rootOff(finger) / off.norm() - 1.0) * off);
    if (first != root && room < 1.0) at(first) = usualPlace(first) + room * (at(first) - usualPlace(first));
    for (const int b : bodiesOf(finger)) {
      const double usual = usualLength(b), length = bone(b).norm();
      const double within =
          std::clamp(length, std::pow(shortest, room) * usual, std::pow(longest, room) * usual);
      if (within != length) move(finger, body_anatomy[b].to, (within / length - 1.0) * bone(b));
      untwist(b, room * twist_reach);
      turnBack(b, room * (body_anatomy[b].from == thumb_metacarpal ? thumb_root_reach : joint_reach));
    }
  }

  const TrackedHand& hand() const { return hand_; }

 private:
  static std::array<int, 3> bodiesOf(int finger) {
    const int first = firstBodyOf(finger);
    return {first, first + 1, first + 2};
  }
  static int rootOf(int finger) { return body_anatomy[firstBodyOf(finger)].from; }
  double rootOff(int finger) const { return scale_ * (finger == 0 ? thumb_root_off : finger_root_off); }
  const Middle& middle() const { return Middle::of(hand_.side); }
  Vector3d& at(int j) { return hand_.joints[j].position; }
  const Vector3d& at(int j) const { return hand_.joints[j].position; }
  Vector3d bone(int b) const { return at(body_anatomy[b].to) - at(body_anatomy[b].from); }

  Vector3d usualPlace(int j) const {
    const Vector3d in_palm = scale_ * (middle().hand.joints[j].position - middle().palm_centre);
    return poses_[palm_body].position + poses_[palm_body].rotation * in_palm;
  }
  double usualLength(int b) const {
    const auto& joints = middle().hand.joints;
    return scale_ * (joints[body_anatomy[b].to].position - joints[body_anatomy[b].from].position).norm();
  }

  // Closeness of the thumb's metacarpal to the index finger's: 0 in the middle of its reach. Up to 1 it may
  // be that of a hand.
  double closeness() const {
    const Vector3d centre = 0.5 * (at(thumb_metacarpal) + at(thumb_proximal));
    const Vector3d usual_centre = 0.5 * (usualPlace(thumb_metacarpal) + usualPlace(thumb_proximal));
    const Capsule index{usualPlace(index_metacarpal), usualPlace(index_proximal), 0.0, 0.0};
    const double usual = index.distance(usual_centre);
    return (usual - index.distance(centre)) / (usual - scale_ * thumb_closest);
  }

  // The joints beyond a joint move and turn with it.
  void move(int finger, int first, const Vector3d& by) {
    for (int j = first; j <= fingers[finger].tip(); ++j) at(j) += by;
  }
  void turn(int b, const Quaterniond& by) {
    const int finger = fingerOf(b);
    const Vector3d joint = at(body_anatomy[b].from);
    for (int j = body_anatomy[b].from; j <= fingers[finger].tip(); ++j) {
      at(j) = joint + by * (at(j) - joint);
      hand_.joints[j].orientation = by * hand_.joints[j].orientation;
    }
    for (int c = b; c <= bodiesOf(finger).back(); ++c) poses_[c].rotation = by * poses_[c].rotation;
  }
  // The rotation that turns a bone to the middle of its reach.
  Quaterniond toMiddle(int b) const {
    return poses_[body_anatomy[b].parent].rotation * poses_[b].rotation.conjugate();
  }
  void untwist(int b, double reach) {
    const Vector3d axis = bone(b).normalized();
    const Quaterniond back = toMiddle(b);
    const double twist = std::remainder(2.0 * std::atan2(back.vec().dot(axis), back.w()), 2.0 * M_PI);
    const double beyond = twist - std::clamp(twist, -reach, reach);
    if (beyond != 0.0) turn(b, Quaterniond(Eigen::AngleAxisd(beyond, axis)));
  }
  void turnBack(int b, double reach) {
    const Quaterniond back = toMiddle(b);
    const double angle = back.angularDistance(Quaterniond::Identity());
    if (angle > reach) turn(b, Quaterniond::Identity().slerp(1.0 - reach / angle, back));
  }

  double scale_;
  TrackedHand hand_;
  BodyPoses poses_;  // relative to those of middle()
};

}  // namespace

TrackedHand withinReach(const TrackedHand& tracked) {
  std::array<double, finger_count> all;
  all.fill(1.0);
  return withinReach(tracked, all);
}

TrackedHand withinReach(const TrackedHand& tracked, const std::array<double, finger_count>& share) {
  LedHand led(tracked);
  std::array<double, finger_count> strangeness, sorted;
  for (int f = 0; f < finger_count; ++f) strangeness[f] = led.strangeness(f);
  sorted = strangeness;
  std::sort(sorted.begin(), sorted.end());
  const double palm_strangeness = sorted[finger_count / 2];
  for (int f = 0; f < finger_count; ++f) {
    const bool missing = tracked.missing[fingers[f].tip()];
    const double room =
        missing ? 0.0 : share[f] * std::min(1.0, 2.0 - std::max(strangeness[f], palm_strangeness));
    if (room > 0.0)
      led.lead(f, room);
    else
      led.rest(f);
  }
  TrackedHand hand = led.hand();
  hand.missing.reset();
  return hand;
}

}  // namespace tactile_clay::hand
