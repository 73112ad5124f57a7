#pragma once

#include <string>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Name of a hand in log lines, such as "left hand 7".
std::string nameOf(const TrackedHand& hand);

/// What is wrong with a hand.
struct HandFaults {
  bool usable = true;              // false: it is no hand
  int fingers = 0;                 // number of wrong fingers, if the hand is usable
  std::vector<std::string> lines;  // one per fault: which hand, which joint, what was expected
};

/// Judges a hand by anatomy, joint by joint, and removes from it what cannot be part of a hand:
///
/// - What the source could not read (`TrackedHand::unread`) is wrong.
/// - Numbers: positions are in metres, finite and within 10 m; orientations are finite and not zero; the
///   confidence is 0 to 1.
/// - Size: the median of its bone lengths, relative to `joint_anatomy`, is 0.4 to 2.
/// - Bones: each is 0.4 to 2 times as long as in a hand of that size, so no two joints coincide.
/// - Place: a palm joint has the right distance to at least half of the other palm joints, within 35 mm times
///   the size.
/// - Handedness: palm and knuckles are on the same side of the wrist, and the knuckles are in order. The
///   palm's +Y, and the side to which fingers bend, are those of a hand of its side.
/// - Radii: their median, relative to those of a hand of that size, is 0.35 to 1.8, and each one 0.2 to 4. If
///   the median is not, all radii are wrong, such as diameters that were sent as radii.
///
/// If a joint beyond the knuckle is wrong, all joints beyond the knuckle become missing. If the knuckle or
/// the metacarpal is wrong, the whole finger is missing. If any joint of the thumb is wrong, the whole thumb
/// is missing. A hand needs palm, wrist and three fingers. If a joint's place is right but its radius is
/// wrong (such as 0 from a tracker that knows none), the radius of `joint_anatomy` at the hand's size
/// replaces it. Joints that are already missing, or lie at the wrist with radius 0 as missing joints do in
/// messages, are missing; no line reports them.
HandFaults judge(TrackedHand& hand);

/// The first line of `judge`, or empty.
std::string faultOf(const TrackedHand& hand);

/// What is wrong with the numbers of a hand, or empty: side, confidence, and positions, orientations and
/// radii of all joints. A hand without such faults can be posed. Only `judge` decides whether it is a hand.
std::string faultOfNumbers(const TrackedHand& hand);

/// What was removed from a frame.
struct LeftOut {
  std::size_t hands = 0, fingers = 0;
  std::vector<std::string> lines;
};

/// Judges all hands, and removes those that are not usable.
LeftOut leaveOutBadHands(std::vector<TrackedHand>& hands);

}  // namespace tactile_clay::hand
