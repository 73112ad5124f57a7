#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "hand/hand_pose.h"
#include "hand/kinematic_hand.h"
#include "hand/skin_template.h"
#include "hand/soft_hands.h"

namespace tactile_clay::hand {

constexpr double spacing = 5e-3;      // m
constexpr double frame = 1.0 / 60.0;  // s

inline std::chrono::nanoseconds stampOf(int k) {
  return std::chrono::nanoseconds(std::llround(1e9 * frame * k));
}

// Palm down (+Y is up); the index finger points down where `pointing`.
inline TrackedHand palmDown(double height, bool pointing = false, double bend = 0.0) {
  HandPose pose;
  for (int finger = 1; finger < finger_count; ++finger)
    pose.fingers[finger].flexion = {bend, bend, 0.8 * bend};
  if (pointing) pose.fingers[1].flexion = {0.7, 0.2, 0.1};
  TrackedHand hand = forwardKinematics(pose);
  double low = std::numeric_limits<double>::infinity();
  for (const JointPose& joint : hand.joints) low = std::min(low, joint.position.y() - joint.radius);
  for (JointPose& joint : hand.joints) joint.position.y() += height - low;
  return hand;
}

/// A soft right hand over a floor at y = 0 that gives each 25 mm^2 of skin `stiffness` N/m, answered a frame
/// late as the clay does.
class Press {
 public:
  explicit Press(double stiffness, bool pointing, double friction = 0.0, double skin_spacing = spacing,
                 const SoftHandParameters& flesh = {})
      : hands(skin_spacing, flesh), stiffness_(stiffness / 25e-6), friction_(friction), pointing_(pointing) {}

  /// One frame; `height` of the tracked hand's lowest point over the floor, m.
  void frame(double height) {
    tracked = palmDown(height, pointing_);
    skin = hands.update({tracked}, stampOf(count));
    std::vector<SkinForce> forces;
    force = area = depth = 0.0;
    for (std::size_t i = 0; i < skin.size(); ++i) {
      const double d = -skin.position[i].y();
      if (d <= 0.0) continue;
      const auto f = static_cast<float>(stiffness_ * skin.area[i] * d);
      const Eigen::Vector3f along(skin.velocity[i].x(), 0.0F, skin.velocity[i].z());
      forces.push_back(
          {static_cast<std::uint32_t>(i),
           f * Eigen::Vector3f::UnitY() - f * static_cast<float>(friction_) * along.stableNormalized()});
      force += f;
      area += skin.area[i];
      depth = std::max(depth, d);
    }
    EXPECT_EQ(hands.react(stampOf(count), forces), 0U);
    ++count;
  }
  void approach(double to) {
    for (int k = 0; k < 60; ++k) frame(0.01 + (to - 0.01) * (k + 1) / 60.0);
  }
  const SoftHand& soft() const { return *hands.hand(Side::right); }

  SoftHands hands;
  TrackedHand tracked;
  Skin skin;
  int count = 0;
  double force = 0.0, area = 0.0, depth = 0.0;  // N, m^2, m

 private:
  double stiffness_, friction_;  // Pa/m, 1
  bool pointing_;
};

inline int settled(SoftHands& hands, const TrackedHand& hand, int from, int frames) {
  for (int k = 0; k < frames; ++k) hands.update({hand}, stampOf(from + k));
  return from + frames;
}

inline double fastest(const Skin& skin) {
  float maximum = 0.0F;
  for (const Eigen::Vector3f& v : skin.velocity) maximum = std::max(maximum, v.norm());
  return maximum;
}

/// At rest the skin of a soft hand is that of the kinematic one.
inline void expectKinematicAtRest(double skin_spacing, const SoftHandParameters& flesh = {}) {
  for (const Side side : {Side::left, Side::right}) {
    const TrackedHand rest = restHand(side, 1.03);
    SoftHands soft(skin_spacing, flesh);
    KinematicHands kinematic(skin_spacing, SkinKind::soft);
    soft.update({rest}, stampOf(0));
    const Skin a = soft.update({rest}, stampOf(1));
    const Skin b = kinematic.update({rest}, stampOf(1));
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(a.region, b.region);
    EXPECT_EQ(a.side, b.side);
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_LT((a.position[i] - b.position[i]).norm(), 1e-5F);
      EXPECT_GT(a.normal[i].dot(b.normal[i]), 0.9999F);
      EXPECT_NEAR(a.area[i] / b.area[i], 1.0F, 1e-2F);
      EXPECT_NEAR(a.pad_distance[i], b.pad_distance[i], 1e-5F);
      EXPECT_LT(a.velocity[i].norm(), 1e-3F);
    }
  }
}

inline bool allFinite(const Skin& skin) {
  for (std::size_t i = 0; i < skin.size(); ++i)
    if (!skin.position[i].allFinite() || !skin.velocity[i].allFinite() ||
        std::abs(skin.normal[i].norm() - 1.0F) > 1e-3F || !(skin.area[i] > 0.0F))
      return false;
  return true;
}

}  // namespace tactile_clay::hand
