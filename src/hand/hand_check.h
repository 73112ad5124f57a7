#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// What is wrong with a hand.
struct HandFaults {
  bool usable = true;              // false: it is no hand
  int fingers = 0;                 // that are wrong, of a usable hand
  std::vector<std::string> lines;  // one a fault: which hand, which joint, what was expected
};

/// Judges a hand by anatomy, joint by joint, and takes out of it what cannot be a hand's:
///
/// - numbers: positions in metres, finite and within 10 m; orientations finite and not zero; confidence 0 to
/// 1;
/// - size: the median of its bones against `joint_anatomy` is 0.4 to 2; each bone is 0.4 to 2 times what it
/// is in a
///   hand of that size, so that no two joints are one;
/// - place: a joint of the palm is as far from most others of the palm as in a hand of that size, within 35
/// mm times it;
/// - handedness: palm and knuckles lie before the wrist, the knuckles in their order, and the palm's +Y, and
/// the side to which fingers bend, are those of a
///   hand of its side;
/// - radii: 0.2 to 4 times those of a hand of that size.
///
/// A wrong joint of a finger makes what lies beyond its knuckle missing, or all of the finger where knuckle
/// or metacarpal are wrong, and all of a thumb. A hand needs palm, wrist and three fingers. A wrong radius of
/// a joint whose place is right (as 0, where a tracker knows none) is replaced by that of `joint_anatomy` at
/// the hand's size. What is missing already, or lies at the wrist with radius 0 as missing joints do in
/// messages, is missing without a word.
HandFaults judge(TrackedHand& hand);

/// The first line of `judge`, or empty.
std::string faultOf(const TrackedHand& hand);

/// What is wrong with the numbers of a hand, or empty: side, confidence, and of all joints positions,
/// orientations and radii. A hand without such faults can be posed; whether it is one is for `judge` to say.
std::string faultOfNumbers(const TrackedHand& hand);

/// What was taken out of a frame.
struct LeftOut {
  std::size_t hands = 0, fingers = 0;
  std::vector<std::string> lines;
};

/// Judges all hands, and removes those that are none.
LeftOut leaveOutBadHands(std::vector<TrackedHand>& hands);

/// Whether a palm that is at `to` was not at `from` `dt` s before: no hand goes farther than 0.05 m at more
/// than 20 m/s.
bool palmJumps(const TrackedHand& from, const TrackedHand& to, double dt);

/// Leaves out hands that jump: a hand that is suddenly elsewhere is there from its second sample on, as
/// another hand, and one that jumps to and fro is nowhere.
class JumpCheck {
 public:
  /// Of hands at a time that does not go back.
  LeftOut leaveOutJumps(std::vector<TrackedHand>& hands, std::chrono::nanoseconds stamp);

 private:
  std::vector<TrackedHand> last_;  // as they came
  std::chrono::nanoseconds stamp_{0};
};

/// Leaves the more confident of two hands of one side (the first of equals); keeps the order.
/// \return how many were removed
std::size_t keepOneHandASide(std::vector<TrackedHand>& hands);

/// One hand a side, the left one first. \throws std::invalid_argument with the line of `faultOfNumbers` where
/// a hand has one
std::vector<TrackedHand> leftThenRight(std::vector<TrackedHand> hands);

}  // namespace tactile_clay::hand
