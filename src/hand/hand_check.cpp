#include "hand/hand_check.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "hand/anatomy.h"
#include "hand/hand_radii.h"
#include "hand/handedness.h"
#include "hand/joint_fault.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

constexpr double farthest = 10.0;       // m from the origin
constexpr double squarest_norm = 1e-6;  // minimum norm of a quaternion
// Trackers have proportions of their own: in six recordings bones are 0.82 to 1.14 times those of the table,
// and places in the palm are 11 mm off. Hands of other trackers differ more, joints that were not located far
// more.
constexpr double shortest_bone = 0.4, longest_bone = 2.0;  // over the table's, at the hand's size
constexpr double off_in_palm = 0.035;                      // m, at scale 1

/// One hand under judgement: what is wrong with each joint.
class Judgement {
 public:
  explicit Judgement(const TrackedHand& hand) : hand_(hand) {}

  HandFaults verdict() {
    takeUnread();
    const std::string no_hand = faultOfAll();
    if (!no_hand.empty())
      return noHand(sideKnown() ? nameOf(hand_) : "hand " + std::to_string(hand_.id), no_hand);
    judgeNumbers();
    for (const Joint joint : {palm, wrist})
      if (!faults_[joint].empty()) return noHand(nameOf(hand_), faults_[joint]);
    takeOutFingers();
    // Told before the size, which fingers that are not there may have made wrong.
    if (anyFault() && fingersLeft(hand_) < min_fingers) return noHand(nameOf(hand_), firstFault());
    scale_ = personScale(hand_);
    if (!(scale_ >= smallest_hand && scale_ <= largest_hand)) {
      std::ostringstream line;
      line.precision(3);
      line << "its bones are " << scale_
           << " times an adult's, expected 0.4 to 2 times (joints of a hand, in metres)";
      return noHand(nameOf(hand_), line.str());
    }
    judgePlaces();
    for (const Joint joint : {palm, wrist})
      if (!faults_[joint].empty()) return noHand(nameOf(hand_), faults_[joint]);
    judgeBones();
    takeOutFingers();
    if (fingersLeft(hand_) < min_fingers) return noHand(nameOf(hand_), firstFault());
    const std::string other_side = faultOfSide(hand_, scale_);
    if (!other_side.empty()) return noHand(nameOf(hand_), other_side);
    HandFaults faults;
    tellFingers(faults);
    const std::string radii = replaceRadii(hand_, scale_);
    if (!radii.empty()) faults.lines.push_back(nameOf(hand_) + ": " + radii);
    return faults;
  }

  std::string faultOfNumbers() {
    std::string fault = faultOfAll();
    judgeNumbers();
    for (int joint = 0; joint < joint_count && fault.empty(); ++joint) {
      fault = faults_[joint];
      const double radius = hand_.joints[joint].radius;
      if (fault.empty() && !(radius >= 0.0 && radius < farthest))
        fault = jointFault(joint, "radius", radius, "finite and not negative");
    }
    return fault.empty() ? fault : "hand " + std::to_string(hand_.id) + ": " + fault;
  }

  /// The judged hand: joints were made missing, and radii replaced.
  const TrackedHand& hand() const { return hand_; }

 private:
  bool sideKnown() const { return hand_.side == Side::left || hand_.side == Side::right; }
  // What is wrong with the hand as a whole.
  std::string faultOfAll() const {
    if (!sideKnown())
      return "side " + std::to_string(static_cast<int>(hand_.side)) + ", expected 0 (left) or 1 (right)";
    if (!(hand_.confidence >= 0.0 && hand_.confidence <= 1.0))
      return "confidence " + std::to_string(hand_.confidence) + ", expected 0 to 1";
    return {};
  }
  const Vector3d& at(int joint) const { return hand_.joints[joint].position; }
  bool there(int joint) const { return !hand_.missing[joint]; }

  static HandFaults noHand(const std::string& who, const std::string& why) {
    return {false, 0, {who + " left out: " + why}};
  }

  // What a source could not read is a fault of its joint.
  void takeUnread() {
    for (const UnreadJoint& unread : std::exchange(hand_.unread, {})) {
      std::string& fault = faults_[unread.joint];
      if (fault.empty()) fault = std::string("joint ") + joint_anatomy[unread.joint].name + ": " + unread.why;
      hand_.missing.set(unread.joint);
    }
  }

  void judgeNumbers() {
    Eigen::IOFormat row(4, 0, " ", " ");
    row.matPrefix = "(";
    row.matSuffix = ")";
    for (int joint = 0; joint < joint_count; ++joint) {
      const JointPose& j = hand_.joints[joint];
      if (joint > wrist && j.radius == 0.0 && j.position == at(wrist)) hand_.missing.set(joint);
      if (!there(joint)) continue;
      if (!j.position.allFinite() || j.position.norm() >= farthest)
        faults_[joint] =
            jointFault(joint, "position", j.position.transpose().format(row), "finite and within 10 m");
      else if (!j.orientation.coeffs().allFinite() || !(j.orientation.norm() > squarest_norm))
        faults_[joint] = jointFault(joint, "orientation", j.orientation.coeffs().transpose().format(row),
                                    "a finite quaternion that is not zero");
    }
  }

  // A joint is in the wrong place if its distance to most other joints of the palm is wrong.
  void judgePlaces() {
    for (const Joint joint : palm_joints) {
      if (!there(joint)) continue;
      int others = 0, off = 0;
      for (const Joint other : palm_joints) {
        if (other == joint || !there(other)) continue;
        const double usual = scale_ * (placeInPalm(joint) - placeInPalm(other)).norm();
        ++others;
        if (std::abs((at(joint) - at(other)).norm() - usual) > scale_ * off_in_palm) ++off;
      }
      if (2 * off <= others) continue;
      const Joint base = joint == wrist ? palm : wrist;
      const double usual = scale_ * (placeInPalm(joint) - placeInPalm(base)).norm();
      faults_[joint] = jointFault(joint, joint == wrist ? "distance to the palm" : "distance to the wrist",
                                  (at(joint) - at(base)).norm(),
                                  "that of a palm, " + range(std::max(0.0, usual - scale_ * off_in_palm),
                                                             usual + scale_ * off_in_palm, " m"));
    }
  }

  void judgeBones() {
    for (int joint = 0; joint < joint_count; ++joint) {
      const JointAnatomy& anatomy = joint_anatomy[joint];
      if (anatomy.bone_length == 0.0 || !there(joint) || !there(anatomy.parent) || !faults_[joint].empty())
        continue;
      const double bone = (at(joint) - at(anatomy.parent)).norm(), usual = scale_ * anatomy.bone_length;
      if (bone < shortest_bone * usual || bone > longest_bone * usual)
        faults_[joint] =
            jointFault(joint, "distance to its parent", bone,
                       range(shortest_bone * usual, longest_bone * usual, " m in a hand of this size"));
    }
  }

  // Makes joints missing that are wrong, or beyond wrong ones.
  void takeOutFingers() {
    for (int f = 0; f < finger_count; ++f) {
      const int palm_part = f == 0 ? 0 : 2;  // joints of a finger that belong to the palm
      int first = fingers[f].count;
      for (int i = fingers[f].count - 1; i >= 0; --i)
        if (!there(fingers[f][i]) || !faults_[fingers[f][i]].empty()) first = i < palm_part ? 0 : palm_part;
      for (int i = first; i < fingers[f].count; ++i) {
        const Joint joint = fingers[f][i];
        hand_.missing.set(joint);
        hand_.joints[joint] = {at(wrist), hand_.joints[wrist].orientation, 0.0};
      }
    }
  }

  bool anyFault() const {
    return std::any_of(faults_.begin(), faults_.end(),
                       [](const std::string& fault) { return !fault.empty(); });
  }

  // The first fault of a joint. If there is none, fingers were missing before.
  std::string firstFault() const {
    for (const std::string& fault : faults_)
      if (!fault.empty()) return fault + "; less than three fingers are left";
    return "less than three fingers, expected palm, wrist and three fingers";
  }

  void tellFingers(HandFaults& faults) const {
    for (int f = 0; f < finger_count; ++f)
      for (int i = 0; i < fingers[f].count; ++i) {
        const std::string& fault = faults_[fingers[f][i]];
        if (fault.empty()) continue;
        ++faults.fingers;
        faults.lines.push_back(nameOf(hand_) + ", " + finger_names[f] + " left out: " + fault);
        break;
      }
  }

  TrackedHand hand_;
  std::array<std::string, joint_count> faults_;
  double scale_ = 0.0;
};

}  // namespace

std::string nameOf(const TrackedHand& hand) {
  return (hand.side == Side::left ? "left hand " : "right hand ") + std::to_string(hand.id);
}

HandFaults judge(TrackedHand& hand) {
  Judgement judgement(hand);
  HandFaults faults = judgement.verdict();
  hand = judgement.hand();
  return faults;
}

std::string faultOf(const TrackedHand& hand) {
  const HandFaults faults = Judgement(hand).verdict();
  return faults.lines.empty() ? std::string() : faults.lines.front();
}

std::string faultOfNumbers(const TrackedHand& hand) {
  return Judgement(hand).faultOfNumbers();
}

LeftOut leaveOutBadHands(std::vector<TrackedHand>& hands) {
  LeftOut out;
  std::vector<TrackedHand> good;
  for (TrackedHand& hand : hands) {
    HandFaults faults = judge(hand);
    for (std::string& line : faults.lines) out.lines.push_back(std::move(line));
    out.fingers += static_cast<std::size_t>(faults.fingers);
    if (faults.usable)
      good.push_back(hand);
    else
      ++out.hands;
  }
  hands = std::move(good);
  return out;
}

}  // namespace tactile_clay::hand
