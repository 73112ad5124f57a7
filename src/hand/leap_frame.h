#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// One frame of Ultraleap's websocket protocol v6 in our units and axes: m; x forward, y left, z up for a
/// user who looks forward over the tracker, that is (-z, -x, y) of Leap. The stamp is the device clock's.
struct LeapFrame {
  TrackedFrame frame;
  std::vector<std::string> dropped;  // one line per hand that could not be used, with the reason
  bool without_bones = false;        // fingers are there, but none has bones, as in the first protocols
};

/// Reads one message. Optional fields may be missing. Metacarpal and wrist joints are then placed by the
/// palm's anatomy, and the tip of the last bone in the direction of `tipPosition`, both at the person's
/// scale. The `type` of a pointable then comes from its id, and that of a hand from the place of its thumb.
/// Radii are the anatomy's at the person's scale. Orientations follow bones and palm, so the frames of left
/// hands are right-handed too, whatever the service's `bases` are. A finger whose pointable is missing, or a
/// joint whose field is missing, has another type, or is not finite or absurd, is missing from its hand, with
/// the reason in `TrackedHand::unread`, which `judge` (hand_check.h) reports. A hand is dropped, but not the
/// frame, if this is true of a field of the hand itself (palm, wrist, id, type, confidence), or if what is
/// left is no hand.
/// @param where the origin of the message, for errors, such as `file:line`
/// @return nothing for an empty line, and for the service's version and event messages
/// @throws std::runtime_error with one line if the text is no such message
std::optional<LeapFrame> parseLeapFrame(const std::string& text, const std::string& where);

/// The protocol that the service's first message names.
/// @return nothing for any other message
std::optional<int> parseLeapVersion(const std::string& text);

/// A device event of the service: the state of one tracker.
struct LeapDevice {
  std::string id;  // digits or a serial number; empty if missing
  bool attached = true;
  bool streaming = true;
};

/// @return nothing if the message is no device event
/// @throws std::runtime_error as parseLeapFrame
std::optional<LeapDevice> parseLeapDevice(const std::string& text, const std::string& where);

}  // namespace tactile_clay::hand
