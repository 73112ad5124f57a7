#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// One frame of Ultraleap's websocket protocol v6 in our terms: m, axes x forward, y left, z up for a user
/// who looks forward over the tracker, that is (-z, -x, y) of Leap; the stamp is the device clock's.
struct LeapFrame {
  TrackedFrame frame;
  std::vector<std::string> dropped;  // why, one line a hand that could not be used
  bool without_bones = false;        // fingers are there, but none has bones, as in the first protocols
};

/// Reads one message. Optional fields may be missing: metacarpal and wrist joints are then placed by the
/// palm's anatomy, the tip of the last bone in the direction of `tipPosition`, both at the person's scale;
/// `type` of a pointable comes from its id, that of a hand from where its thumb is. Radii are the anatomy's
/// at the person's scale. Orientations follow bones and palm, so that left hands are right-handed too
/// whatever the service's `bases` say. A hand with a non-finite or absurd number, with a field of another
/// type, or without a finger, is dropped, the frame is not.
/// @param where the message is from, for errors, such as `file:line`
/// @return nothing for an empty line, and for the service's version and event messages
/// @throws std::runtime_error with one line if it is no such message
std::optional<LeapFrame> parseLeapFrame(const std::string& text, const std::string& where);

/// The protocol that the service's first message names.
/// @return nothing for any other message
std::optional<int> parseLeapVersion(const std::string& text);

/// A device event of the service: what it says of one tracker.
struct LeapDevice {
  std::string id;  // digits or a serial number; empty if missing
  bool attached = true;
  bool streaming = true;
};

/// @return nothing where the message is no device event
/// @throws std::runtime_error as parseLeapFrame
std::optional<LeapDevice> parseLeapDevice(const std::string& text, const std::string& where);

}  // namespace tactile_clay::hand
