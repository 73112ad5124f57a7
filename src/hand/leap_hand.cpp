#include "hand/leap_hand.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <utility>

#include "hand/anatomy.h"
#include "hand/hand_check.h"
#include "hand/hand_pose.h"

namespace tactile_clay::hand::leap {
namespace {

using Eigen::Vector3d;
using SeenPositions = std::array<std::optional<Vector3d>, joint_count>;

// Metres in our axes. A direction gets a length of 1/1000; its user normalises it.
Vector3d fromLeap(const Vector3d& v) {
  return Vector3d(-v.z(), -v.x(), v.y()) * 1e-3;
}

std::optional<Vector3d> optionalVector(const Json& object, const char* key) {
  constexpr double absurd = 1e5;  // mm
  const auto value = vector(object, key);
  if (!value) return std::nullopt;
  if (!value->allFinite() || value->cwiseAbs().maxCoeff() >= absurd)
    throw std::runtime_error(std::string(key) + " is not finite, expected mm within the tracker's reach");
  return fromLeap(*value);
}

Vector3d requiredVector(const Json& object, const char* key) {
  const auto value = optionalVector(object, key);
  if (!value) throw std::runtime_error(std::string(key) + " is missing, expected an array of three numbers");
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

// What the pointables of a hand tell about its joints.
struct KnownJoints {
  SeenPositions positions;
  std::array<const Json*, finger_count> pointables{};  // nullptr: none, or none that can be read
  std::vector<UnreadJoint> unread;

  // Takes the position that a function returns, or its error as the fault of this joint alone.
  template <typename Read>
  void read(Joint joint, const Read& position) {
    try {
      positions[joint] = position();
    } catch (const std::runtime_error& error) {
      unread.push_back({joint, error.what()});
    }
  }
};

void readFinger(int finger, KnownJoints& known) {
  const Json& pointable = *known.pointables[finger];
  const FingerJoints& joints = fingers[finger];
  const int mcp = joints.count - 4;  // the thumb has no bone before it, its carpPosition is its mcpPosition
  if (mcp > 0) known.read(joints[0], [&] { return optionalVector(pointable, "carpPosition"); });
  static constexpr std::array<const char*, 3> ends = {"mcpPosition", "pipPosition", "dipPosition"};
  for (int i = 0; i < 3; ++i)
    known.read(joints[mcp + i], [&] { return requiredVector(pointable, ends[static_cast<std::size_t>(i)]); });
  known.read(joints.tip(), [&] { return optionalVector(pointable, "btipPosition"); });
}

KnownJoints knownJoints(const Pointables& pointables, const std::string& hand_id) {
  KnownJoints known;
  std::string fault = pointables.fault;
  const auto own = pointables.of_hand.find(hand_id);
  for (const Json* each : own == pointables.of_hand.end() ? std::vector<const Json*>() : own->second) {
    try {
      const int finger = fingerType(*each);
      if (finger >= 0) known.pointables[finger] = each;
    } catch (const std::runtime_error& error) {
      fault = std::string("a pointable of this hand: ") + error.what();
    }
  }
  for (int finger = 0; finger < finger_count; ++finger) {
    if (known.pointables[finger] != nullptr)
      readFinger(finger, known);
    else
      known.unread.push_back({fingers[finger].first, "no pointable for this finger, expected one with type " +
                                                         std::to_string(finger) +
                                                         (fault.empty() ? "" : "; " + fault)});
  }
  return known;
}

// Seen from the back of a right hand with its fingers up, the thumb is on the left, and the knuckles follow
// in their order.
Side sideOf(const Json& hand, const SeenPositions& positions, const Eigen::Matrix3d& rotation) {
  const std::string type = handType(hand);
  if (type == "left") return Side::left;
  if (type == "right") return Side::right;
  if (!type.empty()) throw std::runtime_error("type '" + type + "', expected left or right");
  std::vector<Vector3d> knuckles;
  for (const FingerJoints& finger : fingers)
    if (const auto& knuckle = positions[finger[1]]) knuckles.push_back(*knuckle);
  if (knuckles.size() < 2)
    throw std::runtime_error("type is missing and less than two knuckles are known, expected left or right");
  return (knuckles.back() - knuckles.front()).dot(rotation.col(0)) > 0.0 ? Side::right : Side::left;
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

// The wrist by a metacarpal, since these are fixed to it: by that of the middle finger, or the next one that
// is known.
Vector3d wristPosition(const PalmFrame& frame, const SeenPositions& positions) {
  for (const int finger : {2, 1, 3, 4})
    if (const auto& base = positions[fingers[finger].first])
      return *base + frame.offset(wrist_in_palm - palm_anatomy[finger].base);
  return frame.origin + frame.offset(wrist_in_palm);
}

// Adds the joints that messages may leave out, and takes out those that could not be read.
void fillMissing(const PalmFrame& frame, const Json& hand, KnownJoints& known) {
  SeenPositions& positions = known.positions;
  for (int finger = 0; finger < finger_count; ++finger) {
    const FingerJoints& joints = fingers[finger];
    const PalmAnatomy& anatomy = palm_anatomy[finger];
    if (!positions[joints[0]] && positions[joints[1]])
      positions[joints[0]] = *positions[joints[1]] + frame.offset(anatomy.base - anatomy.knuckle);
    const auto& pip = positions[joints[joints.count - 3]];
    const auto& dip = positions[joints[joints.count - 2]];
    if (!positions[joints.tip()] && pip && dip)
      known.read(joints.tip(), [&] {
        return boneTip(*known.pointables[finger], *pip, *dip,
                       joint_anatomy[joints.tip()].bone_length * frame.scale);
      });
  }
  for (const UnreadJoint& joint : known.unread) positions[joint.joint].reset();
  positions[palm] = frame.origin;
  positions[wrist] = optionalVector(hand, "wrist");
  if (!positions[wrist]) positions[wrist] = wristPosition(frame, positions);
}

void setJoints(const PalmFrame& frame, const SeenPositions& positions, TrackedHand& hand) {
  std::array<JointPose, joint_count>& poses = hand.joints;
  for (int joint = 0; joint < joint_count; ++joint) {
    hand.missing[joint] = !positions[joint];
    poses[joint].position = positions[joint].value_or(*positions[wrist]);
    poses[joint].orientation = Eigen::Quaterniond(frame.rotation);
    poses[joint].radius = positions[joint] ? joint_anatomy[joint].radius * frame.scale : 0.0;
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
}

}  // namespace

TrackedHand readHand(const Json& hand, const std::string& id, const Pointables& pointables) {
  TrackedHand tracked;
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), tracked.id);
  if (error != std::errc() || end != id.data() + id.size())
    throw std::runtime_error("expected a whole number as its id");
  PalmFrame frame{};
  frame.origin = requiredVector(hand, "palmPosition");
  frame.rotation = palmRotation(hand);
  KnownJoints known = knownJoints(pointables, id);
  frame.side = tracked.side = sideOf(hand, known.positions, frame.rotation);
  frame.scale = personScale(known.positions);
  fillMissing(frame, hand, known);
  setJoints(frame, known.positions, tracked);
  tracked.unread = std::move(known.unread);
  tracked.confidence = std::clamp(number(hand, "confidence").value_or(1.0), 0.0, 1.0);
  // Faults of single fingers are reported where the hands of all sources are judged.
  TrackedHand judged = tracked;
  const HandFaults faults = judge(judged);
  if (!faults.usable) throw std::runtime_error(faults.lines.front());
  return tracked;
}

}  // namespace tactile_clay::hand::leap
