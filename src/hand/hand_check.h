#pragma once

#include <string>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// A hand in lines about it, such as "left hand 7".
std::string nameOf(const TrackedHand& hand);

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

}  // namespace tactile_clay::hand
