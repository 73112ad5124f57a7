#include "hand/hand_check.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "hand/anatomy.h"

namespace tactile_clay::hand {
namespace {

constexpr double farthest = 10.0;       // m
constexpr double thickest = 0.1;        // m
constexpr double longest_bone = 0.2;    // m
constexpr double squarest_norm = 1e-6;  // of a quaternion

template <typename Value>
std::string fault(const TrackedHand& hand, int joint, const char* what, const Value& value,
                  const char* expected) {
  std::ostringstream line;
  line << (hand.side == Side::left ? "left" : "right") << " hand " << hand.id << ", joint "
       << joint_anatomy[joint].name << ": " << what << " " << value << ", expected " << expected;
  return line.str();
}

}  // namespace

std::string faultOf(const TrackedHand& hand) {
  if (hand.side != Side::left && hand.side != Side::right)
    return "hand " + std::to_string(hand.id) + ": side " + std::to_string(static_cast<int>(hand.side)) +
           ", expected 0 (left) or 1 (right)";
  const Eigen::IOFormat row(4, 0, " ", " ", "", "", "(", ")");
  for (int joint = 0; joint < joint_count; ++joint) {
    const JointPose& j = hand.joints[joint];
    if (!j.position.allFinite() || j.position.norm() >= farthest)
      return fault(hand, joint, "position", j.position.transpose().format(row), "finite and within 10 m");
    if (!j.orientation.coeffs().allFinite() || !(j.orientation.norm() > squarest_norm))
      return fault(hand, joint, "orientation", j.orientation.coeffs().transpose().format(row),
                   "a finite quaternion that is not zero");
    if (!(j.radius >= 0.0 && j.radius <= thickest))
      return fault(hand, joint, "radius", j.radius, "0 to 0.1 m");
  }
  for (int joint = 0; joint < joint_count; ++joint) {
    const Joint parent = joint_anatomy[joint].parent;
    const double bone = (hand.joints[joint].position - hand.joints[parent].position).norm();
    if (bone > longest_bone) return fault(hand, joint, "distance to its parent", bone, "at most 0.2 m");
  }
  if (!(hand.confidence >= 0.0 && hand.confidence <= 1.0))
    return fault(hand, palm, "confidence of the hand", hand.confidence, "0 to 1");
  return {};
}

std::size_t keepOneHandASide(std::vector<TrackedHand>& hands) {
  const std::size_t before = hands.size();
  std::vector<TrackedHand> kept;
  for (const TrackedHand& hand : hands) {
    const auto same = std::find_if(kept.begin(), kept.end(),
                                   [&](const TrackedHand& other) { return other.side == hand.side; });
    if (same == kept.end()) {
      kept.push_back(hand);
    } else if (hand.confidence > same->confidence) {
      *same = hand;
    }
  }
  hands = std::move(kept);
  return before - hands.size();
}

}  // namespace tactile_clay::hand
