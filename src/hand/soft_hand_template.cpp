#include "hand/soft_hand_template.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "hand/hand_pose.h"
#include "hand/hand_shape.h"
#include "hand/skin_template.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

// A bone fills half the radius, or all but 6 mm where the hand is thick.
constexpr double bone_share = 0.5;
constexpr double thickest_flesh = 6e-3;  // m
// Bones end this share of the radius before a joint that bends, to leave flesh that can.
constexpr double joint_share = 0.6;

struct Core {
  int bone, body;
  Capsule capsule;
};

double coreRadius(double radius) {
  return std::max(bone_share * radius, radius - thickest_flesh);
}

// Whether a part's flesh hangs on a body: that of the palm on palm and thumb's metacarpal, a finger's on its
// own bones and on the one that it grows from.
bool hangsOn(int part, int body) {
  if (part == 0) return body == palm_body || body == firstBodyOf(0);
  if (body == palm_body) return part > 1;
  return fingerOf(body) == part - 1;
}

// The solid inside of each bone. The thumb's web has none: it is flesh between two bodies.
std::vector<Core> cores(const TrackedHand& hand) {
  constexpr int thumb_web = static_cast<int>(bones.size()) - 1;
  std::vector<Core> all;
  for (int bone = 0; bone < thumb_web; ++bone) {
    const int body = bodyOfBone(bone);
    Capsule capsule = boneCapsule(bones[bone], hand);
    const double length = capsule.length();
    const Vector3d axis = (capsule.to - capsule.from) / length;
    const bool ends = std::any_of(fingers.begin(), fingers.end(), [bone](const FingerJoints& finger) {
      return bones[bone].to == finger.tip();
    });
    const double before = body == palm_body ? 0.0 : joint_share * capsule.radius_from;
    const double after = ends || bone >= chain_bone_count ? 0.0
                         : body == palm_body              ? capsule.radius_to
                                                          : joint_share * capsule.radius_to;
    capsule.from += std::min(before, 0.4 * length) * axis;
    capsule.to -= std::min(after, 0.4 * length) * axis;
    capsule.radius_from = coreRadius(capsule.radius_from);
    capsule.radius_to = coreRadius(capsule.radius_to);
    all.push_back({bone, body, capsule});
  }
  return all;
}

/// @param may_be_bone else what is inside a bone is flesh too
NodeBinding bind(const Vector3d& x, const std::vector<Core>& all, bool may_be_bone) {
  std::array<double, body_count> distance;
  distance.fill(std::numeric_limits<double>::infinity());
  for (const Core& core : all) distance[core.body] = std::min(distance[core.body], core.capsule.distance(x));
  const auto nearest = std::min_element(distance.begin(), distance.end());
  const int body = static_cast<int>(nearest - distance.begin());
  const double d = *nearest;
  *nearest = std::numeric_limits<double>::infinity();
  const auto next = std::min_element(distance.begin(), distance.end());
  const double e = *next;
  // What lies inside two bones belongs to neither.
  if (may_be_bone && d < 0.0 && e >= 0.0) return {body, true, body, 0.0F};
  const double near = std::max(d, 1e-4), far = std::max(e, 1e-4);
  return {body, false, static_cast<int>(next - distance.begin()),
          static_cast<float>(near * near / (near * near + far * far))};
}

void append(SoftHandTemplate& hand, const FleshMesh& part, const std::vector<Core>& all) {
  std::vector<NodeBinding> bindings;
  for (const Vector3d& x : part.nodes) bindings.push_back(bind(x, all, true));
  const auto inBones = [&](const std::array<int, 4>& t) {
    return std::all_of(t.begin(), t.end(), [&](int n) { return bindings[n].rigid; });
  };
  const auto ofOneBody = [&](const std::array<int, 4>& t) {
    return std::all_of(t.begin(), t.end(), [&](int n) { return bindings[n].body == bindings[t[0]].body; });
  };
  // Between two bones there is flesh, or nothing could keep it right side out.
  for (const auto& t : part.tetrahedra)
    if (inBones(t) && !ofOneBody(t))
      for (const int n : t) bindings[n] = bind(part.nodes[n], all, false);
  // Nodes of bone that carry neither flesh nor skin are left out.
  std::vector<int> renamed(part.nodes.size(), -1);
  for (const auto& t : part.tetrahedra)
    if (!inBones(t))
      for (const int n : t) renamed[n] = 0;
  for (const auto& t : part.triangles)
    for (const int n : t) renamed[n] = 0;
  for (std::size_t n = 0; n < part.nodes.size(); ++n) {
    if (renamed[n] < 0) continue;
    renamed[n] = static_cast<int>(hand.mesh.nodes.size());
    hand.mesh.nodes.push_back(part.nodes[n]);
    hand.bindings.push_back(bindings[n]);
  }
  for (std::array<int, 4> t : part.tetrahedra) {
    if (inBones(t)) continue;
    for (int& n : t) n = renamed[n];
    hand.mesh.tetrahedra.push_back(t);
  }
  for (std::array<int, 3> t : part.triangles) {
    for (int& n : t) n = renamed[n];
    hand.mesh.triangles.push_back(t);
  }
}

}  // namespace

int fleshPart(Joint region) {
  for (int finger = 0; finger < finger_count; ++finger)
    if (region > fingers[finger].first && region <= fingers[finger].tip()) return 1 + finger;
  return 0;
}

SoftHandTemplate makeSoftHandTemplate(Side side, double finger_cell, double palm_cell) {
  SoftHandTemplate hand;
  hand.rest = restHand(Side::right, 1.0);
  const std::vector<Core> all = cores(hand.rest);
  for (int part = 0; part <= finger_count; ++part) {
    std::vector<Capsule> capsules;
    for (const Bone& bone : bones)
      if (fleshPart(bone.region) == part) capsules.push_back(boneCapsule(bone, hand.rest));
    hand.part_begin[part] = static_cast<int>(hand.mesh.triangles.size());
    std::vector<Core> own;
    std::copy_if(all.begin(), all.end(), std::back_inserter(own), [&](const Core& core) {
      // Of the palm a finger knows the metacarpals, which end before its first joint.
      return hangsOn(part, core.body) && (part == 0 || core.bone < chain_bone_count);
    });
    append(hand, fillCapsules(capsules, part == 0 ? palm_cell : finger_cell), own);
  }
  hand.part_begin.back() = static_cast<int>(hand.mesh.triangles.size());
  return side == Side::left ? mirroredTemplate(std::move(hand)) : hand;
}

SoftHandTemplate mirroredTemplate(SoftHandTemplate hand) {
  hand.rest = restHand(hand.rest.side == Side::right ? Side::left : Side::right, 1.0);
  for (Vector3d& x : hand.mesh.nodes) x = mirrored(x);
  for (auto& t : hand.mesh.tetrahedra) std::swap(t[2], t[3]);
  for (auto& t : hand.mesh.triangles) std::swap(t[1], t[2]);
  return hand;
}

}  // namespace tactile_clay::hand
