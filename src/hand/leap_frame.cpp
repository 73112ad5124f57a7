#include "hand/leap_frame.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "hand/anatomy.h"
#include "hand/hand_check.h"
#include "hand/hand_pose.h"
#include "hand/leap_json.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
using leap::Json;
using Positions = std::array<std::optional<Vector3d>, joint_count>;

// Of a frame. Trackers see two hands; with tools each has some ten pointables.
constexpr std::size_t max_hands = 100, max_pointables = 1000;

void requireAtMost(const Json& list, std::size_t maximum, const char* what) {
  if (list.size() > maximum)
    throw std::runtime_error("has " + std::to_string(list.size()) + " " + what + ", expected at most " +
                             std::to_string(maximum));
}

struct Pointables {
  std::map<std::string, std::vector<const Json*>> of_hand;  // by the id of the hand
  std::string fault;  // one line about those that name no hand; empty: there are none
};

Pointables sorted(const Json& pointables) {
  Pointables result;
  for (std::size_t i = 0; i < pointables.size(); ++i) {
    try {
      result.of_hand[leap::id(pointables[i], "handId")].push_back(&pointables[i]);
    } catch (const std::runtime_error& error) {
      result.fault = "pointable " + std::to_string(i) + ' ' + error.what();
    }
  }
  return result;
}

// Metres in our axes. A direction gets a length of 1/1000; its user normalises it.
Vector3d fromLeap(const Vector3d& v) {
  return Vector3d(-v.z(), -v.x(), v.y()) * 1e-3;
}

std::optional<Vector3d> optionalVector(const Json& object, const char* key) {
  constexpr double absurd = 1e5;  // mm
  const auto value = leap::vector(object, key);
  if (!value) return std::nullopt;
  if (!(value->cwiseAbs().maxCoeff() < absurd))
    throw std::runtime_error(std::string(key) + " is not finite, expected mm within the tracker's reach");
  return fromLeap(*value);
}

Vector3d requiredVector(const Json& object, const char* key) {
  const auto value = optionalVector(object, key);
  if (!value) throw std::runtime_error(std::string(key) + " is missing");
  return *value;
}

// Rigid frame of the palm, and places that are fixed to it, for either side.
struct PalmFrame {
  Side side;
  Vector3d origin;
  Eigen::Matrix3d rotation;  // +Y dorsal, -Z along the palm
  double scale;

  // A direction or offset given for a right hand at scale 1.
  Vector3d offset(const Vector3d& v) const {
    return rotation * ((side == Side::left ? mirrored(v) : v) * scale);
  }
  // The mirror image of +X is -X of the right-handed frame.
  Vector3d flexionAxis(int finger) const {
    const Vector3d axis = offset(palm_anatomy[finger].flexion_axis);
    return side == Side::left ? Vector3d(-axis) : axis;
  }
};

Eigen::Matrix3d palmRotation(const Json& hand) {
  const Vector3d dorsal = -requiredVector(hand, "palmNormal");
  const Vector3d back = -requiredVector(hand, "direction");
  const Vector3d x = dorsal.cross(back);
  if (dorsal.norm() < 1e-6 || x.norm() < 1e-3 * dorsal.norm() * back.norm() || back.norm() < 1e-6)
    throw std::runtime_error(
        "palmNormal and direction span no plane, expected two unit vectors at right angles");
  Eigen::Matrix3d rotation;
  rotation << x.normalized(), dorsal.normalized(), x.cross(dorsal).normalized();
  return rotation;
}

// Joint positions that the pointables of a hand contain.
Positions knownJoints(const Pointables& pointables, const std::string& hand_id,
                      std::array<const Json*, finger_count>& found) {
  Positions positions;
  const auto own = pointables.of_hand.find(hand_id);
  for (const Json* each : own == pointables.of_hand.end() ? std::vector<const Json*>() : own->second) {
    const Json& pointable = *each;
    const int finger = leap::fingerType(pointable);
    if (finger < 0) continue;
    found[finger] = &pointable;
    const FingerJoints& joints = fingers[finger];
    const int mcp = joints.count - 4;  // the thumb has no bone before it, its carpPosition is its mcpPosition
    if (mcp > 0) positions[joints[0]] = optionalVector(pointable, "carpPosition");
    positions[joints[mcp]] = requiredVector(pointable, "mcpPosition");
    positions[joints[mcp + 1]] = requiredVector(pointable, "pipPosition");
    positions[joints[mcp + 2]] = requiredVector(pointable, "dipPosition");
    positions[joints[mcp + 3]] = optionalVector(pointable, "btipPosition");
  }
  static const std::array<const char*, finger_count> names = {"thumb", "index", "middle", "ring", "little"};
  for (int finger = 0; finger < finger_count; ++finger)
    if (found[finger] == nullptr)
      throw std::runtime_error(std::string("no pointable for its ") + names[finger] + " finger" +
                               (pointables.fault.empty() ? "" : "; " + pointables.fault));
  return positions;
}

// Seen from the back of a right hand with its fingers up, the thumb is on the left.
Side sideOf(const Json& hand, const Positions& positions, const Eigen::Matrix3d& rotation) {
  const std::string type = leap::handType(hand);
  if (type == "left") return Side::left;
  if (type == "right") return Side::right;
  if (!type.empty()) throw std::runtime_error("type '" + type + "', expected left or right");
  const Vector3d across = *positions[little_proximal] - *positions[thumb_proximal];
  return across.dot(rotation.col(0)) > 0.0 ? Side::right : Side::left;
}

// `direction` of a pointable is that of the phalanx before the last one. `tipPosition` may be wrong along the
// last bone, but lies in its direction.
Vector3d boneTip(const Json& pointable, const Vector3d& pip, const Vector3d& dip, double length) {
  constexpr double shortest = 1e-3;  // m, below which a difference has no direction
  if (const auto tip = optionalVector(pointable, "tipPosition"); tip && (*tip - dip).norm() > shortest)
    return dip + length * (*tip - dip).normalized();
  if (const auto direction = optionalVector(pointable, "direction"); direction && direction->norm() > 1e-6)
    return dip + length * direction->normalized();
  return dip + length * (dip - pip).normalized();
}

void fillMissing(const PalmFrame& frame, const std::array<const Json*, finger_count>& pointables,
                 const Json& hand, Positions& positions) {
  for (int finger = 0; finger < finger_count; ++finger) {
    const FingerJoints& joints = fingers[finger];
    const PalmAnatomy& anatomy = palm_anatomy[finger];
    if (!positions[joints[0]])
      positions[joints[0]] = *positions[joints[1]] + frame.offset(anatomy.base - anatomy.knuckle);
    if (!positions[joints.tip()])
      positions[joints.tip()] = boneTip(*pointables[finger], *positions[joints[joints.count - 3]],
                                        *positions[joints[joints.count - 2]],
                                        joint_anatomy[joints.tip()].bone_length * frame.scale);
  }
  positions[palm] = frame.origin;
  positions[wrist] = optionalVector(hand, "wrist");
  if (!positions[wrist])
    positions[wrist] = *positions[middle_metacarpal] + frame.offset(wrist_in_palm - palm_anatomy[2].base);
}

std::array<JointPose, joint_count> jointPoses(const PalmFrame& frame, const Positions& positions) {
  std::array<JointPose, joint_count> poses;
  for (int joint = 0; joint < joint_count; ++joint) {
    poses[joint].position = *positions[joint];
    poses[joint].orientation = Eigen::Quaterniond(frame.rotation);
    poses[joint].radius = joint_anatomy[joint].radius * frame.scale;
  }
  for (int finger = 0; finger < finger_count; ++finger) {
    const FingerJoints& joints = fingers[finger];
    const Vector3d axis = frame.flexionAxis(finger);
    for (int i = 0; i + 1 < joints.count; ++i) {
      const Vector3d bone = poses[joints[i + 1]].position - poses[joints[i]].position;
      // A bone of length 0 has the orientation of the bone before.
      poses[joints[i]].orientation = bone.norm() > 1e-6 ? boneOrientation(bone, axis)
                                     : i > 0            ? poses[joints[i - 1]].orientation
                                                        : poses[palm].orientation;
    }
    poses[joints.tip()].orientation = poses[joints[joints.count - 2]].orientation;
  }
  return poses;
}

TrackedHand readHand(const Json& hand, const std::string& id, const Pointables& pointables) {
  TrackedHand tracked;
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), tracked.id);
  if (error != std::errc() || end != id.data() + id.size())
    throw std::runtime_error("expected a whole number as its id");
  std::array<const Json*, finger_count> found{};
  Positions positions = knownJoints(pointables, id, found);
  PalmFrame frame{};
  frame.origin = requiredVector(hand, "palmPosition");
  frame.rotation = palmRotation(hand);
  frame.side = tracked.side = sideOf(hand, positions, frame.rotation);
  frame.scale = personScale(positions);
  if (!(frame.scale > 0.3 && frame.scale < 3.0))
    throw std::runtime_error("its bones are " + std::to_string(frame.scale) +
                             " times an adult's, expected 0.3 to 3 times");
  fillMissing(frame, found, hand, positions);
  tracked.joints = jointPoses(frame, positions);
  tracked.confidence = std::clamp(leap::number(hand, "confidence").value_or(1.0), 0.0, 1.0);
  // Faults of single fingers are reported where the hands of all sources are judged.
  TrackedHand judged = tracked;
  const HandFaults faults = judge(judged);
  if (!faults.usable) throw std::runtime_error(faults.lines.front());
  return tracked;
}

constexpr char no_bones[] =
    "its fingers have no bones, as in Leap's protocols 1 to 4, expected protocol 5 or 6";

bool haveNoBones(const Json& pointables) {
  return !pointables.empty() && std::none_of(pointables.begin(), pointables.end(), [](const Json& pointable) {
    return pointable.is_object() && pointable.contains("mcpPosition");
  });
}

std::runtime_error noLeapMessage(const std::string& where, const std::exception& error) {
  return std::runtime_error(where + ": " + error.what() +
                            ", expected one message of Leap's JSON protocol v6");
}

}  // namespace

std::optional<LeapFrame> parseLeapFrame(const std::string& text, const std::string& where) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) return std::nullopt;
  try {
    const Json message = leap::parse(text);
    if (!message.is_object()) throw std::runtime_error("is not an object");
    if (!message.contains("hands")) {
      if (message.contains("version") || message.contains("event")) return std::nullopt;
      throw std::runtime_error("has neither hands nor version nor event");
    }
    const Json& hands = leap::array(message, "hands");
    const Json& pointables = leap::array(message, "pointables");
    requireAtMost(hands, max_hands, "hands");
    requireAtMost(pointables, max_pointables, "pointables");
    LeapFrame result;
    result.frame.stamp = leap::timestamp(message);
    const Pointables by_hand = sorted(pointables);
    result.without_bones = haveNoBones(pointables);
    for (std::size_t i = 0; i < hands.size(); ++i) {
      std::string name = "hand " + std::to_string(i) + " of the frame";
      try {
        const std::string id = leap::id(hands[i], "id");
        name = "hand " + id;
        result.frame.hands.push_back(readHand(hands[i], id, by_hand));
      } catch (const std::runtime_error& error) {
        result.dropped.push_back(where + ": " + name +
                                 " is dropped: " + (result.without_bones ? no_bones : error.what()));
      }
    }
    return result;
  } catch (const std::exception& error) {
    throw noLeapMessage(where, error);
  }
}

std::optional<int> parseLeapVersion(const std::string& text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object() || message.contains("hands")) return std::nullopt;
  const auto version = message.find("version");
  if (version == message.end() || !version->is_number_integer()) return std::nullopt;
  return version->get<int>();
}

std::optional<LeapDevice> parseLeapDevice(const std::string& text, const std::string& where) {
  try {
    const Json message = leap::parse(text);
    if (!message.is_object()) throw std::runtime_error("is not an object");
    const Json& event = leap::object(message, "event");
    const auto type = event.find("type");
    if (type == event.end() || *type != "deviceEvent") return std::nullopt;
    const Json& state = leap::object(event, "state");
    return LeapDevice{leap::id(state, "id"), leap::flag(state, "attached", true),
                      leap::flag(state, "streaming", true)};
  } catch (const std::exception& error) {
    throw noLeapMessage(where, error);
  }
}

}  // namespace tactile_clay::hand
