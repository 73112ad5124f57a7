#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "clay/clay.h"
#include "hand/hand_pose.h"
#include "hand/hand_shape.h"
#include "hand/kinematic_hand.h"
#include "support/setups.h"

/// Hands that move through clay, and how much of it is then inside them or below the table.
namespace tactile_clay::clay {

constexpr double spacing = 0.005, frame = 1.0 / 60.0, degree = M_PI / 180.0;

/// A hand, flat or bent, with the directions of its palm and its fingers: the flat skin of its fingers is at
/// `reach` along that of the palm, their middle at `middle` across it.
inline hand::TrackedHand handAt(hand::Side side, const Eigen::Vector3d& palm, const Eigen::Vector3d& fingers,
                                double reach, const Eigen::Vector3d& middle, double bend = 0.0,
                                double thumb = -0.6) {
  hand::HandPose pose;
  pose.side = side;
  pose.fingers[0].abduction = thumb;  // beside the palm
  for (int finger = 1; finger < hand::finger_count; ++finger)
    pose.fingers[finger].flexion = {bend, bend, 0.7 * bend};
  pose.wrist.linear() << palm.cross(fingers), -palm, -fingers;
  pose.wrist.translation() = middle + (reach - 0.012 - middle.dot(palm)) * palm - 0.11 * fingers;
  return hand::forwardKinematics(pose);
}

class Leakage : public ::testing::Test {
 protected:
  explicit Leakage(const std::vector<InitialParticle>& particles = block(8, 8, 8, spacing))
      : clay(configOf(), {modellingClay()}, particles) {}

  static Material modellingClay() {
    Material material;
    material.yield_strain = 0.05;
    return material;
  }

  static ClayConfig configOf() {
    ClayConfig config;
    config.spacing = spacing;
    config.threads = 2;
    return config;
  }

  /// One frame to where the hands then are.
  void advance(const std::vector<hand::TrackedHand>& hands) {
    const auto stamp = std::chrono::nanoseconds(std::llround(1e9 * (clay.time() + frame)));
    const Skin skin = skins.update(hands, stamp);
    clay.advance(skin, {ground()}, frame);
    inside = under = 0;
    deepest = 0.0;
    for (std::size_t i = 0; i < clay.particles().size(); ++i) {
      const Eigen::Vector3d x = clay.particles().position.at(i).cast<double>();
      double distance = 1.0;
      for (const hand::TrackedHand& hand : hands) distance = std::min(distance, handDistance(hand, x));
      inside += distance < 0.0 ? 1 : 0;
      under += x.z() < 0.0 ? 1 : 0;
      deepest = std::min(deepest, distance);
    }
    float pressed = 0.0f;
    for (const SkinForce& f : clay.skinForces()) pressed += f.force.norm();
    touched = touched || pressed > 0.1f;
  }

  Clay clay;
  hand::KinematicHands skins{spacing};
  int inside = 0, under = 0;  // particles
  double deepest = 0.0;       // m
  bool touched = false;       // with more than 0.1 N; what lies on the palm weighs 0.126 N
};

}  // namespace tactile_clay::clay
