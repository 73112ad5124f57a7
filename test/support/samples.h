#pragma once

#include <string>
#include <vector>

#include "support/setups.h"

/// Samples and plates of a rheometer.
namespace tactile_clay::clay {

/// How finely a scene is resolved.
struct Resolution {
  Budget budget;
  double spacing;  // m
};

inline std::string nameOf(const Resolution& r) {
  return std::to_string(r.budget.substeps) + "x" + std::to_string(r.budget.iterations) + "Spacing" +
         std::to_string(std::lround(1e6 * r.spacing)) + "um";
}

/// `balanced`, a finer budget, and a finer lattice.
inline std::vector<Resolution> resolutions() {
  return {{{4, 8}, 0.005}, {{8, 16}, 0.005}, {{4, 8}, 0.00375}};
}

/// Clay without gravity that never sleeps.
inline ClayConfig weightless(const Resolution& r) {
  ClayConfig config;
  config.spacing = r.spacing;
  config.budget = r.budget;
  config.gravity.setZero();
  config.sleeping = false;
  config.threads = 1;
  return config;
}

/// Clay that solids hold without slip, once it touched them.
inline Material sticking(double viscosity, double stiffness) {
  Material m;
  m.viscosity = viscosity, m.stiffness = stiffness;
  m.friction = 10.0, m.adhesion = 1e5;
  return m;
}

/// A cylinder about z, standing on the origin, cut out of a cubic lattice that is turned about `lattice`'s
/// axes.
inline std::vector<InitialParticle> cylinder(double radius, double height, double spacing,
                                             const Eigen::Matrix3d& lattice = Eigen::Matrix3d::Identity()) {
  std::vector<InitialParticle> particles;
  const Eigen::Vector3d middle(0.0, 0.0, 0.5 * height);
  const int reach = static_cast<int>(std::ceil(std::hypot(radius, 0.5 * height) / spacing));
  // For an even number of layers, as many on each side of the middle.
  const double shift = std::lround(height / spacing) % 2 == 0 ? 0.5 : 0.0;
  for (int z = -reach - 1; z <= reach; ++z) {
    for (int y = -reach - 1; y <= reach; ++y) {
      for (int x = -reach - 1; x <= reach; ++x) {
        const Eigen::Vector3d at = lattice * (spacing * Eigen::Vector3d(x + 0.5, y + 0.5, z + shift));
        if (std::abs(at.z()) >= 0.5 * height || at.head<2>().norm() >= radius) continue;
        InitialParticle p;
        p.position = (middle + at).cast<float>();
        p.velocity.setZero();
        particles.push_back(p);
      }
    }
  }
  return particles;
}

/// Two level plates. The lower one has its face at z = 0, the upper one at `height`; `bite` of each is in the
/// clay, so that contacts close in the first step.
struct Plates {
  explicit Plates(double height, double bite = 0.0) {
    lower.size = upper.size = {1.0, 1.0, 0.1};
    lower.pose.translation().z() = -0.1 + bite;
    upper.pose.translation().z() = height + 0.1 - bite;
  }
  /// Moves both for a frame.
  void advance(Clay& clay) {
    const double frame = clay.config().frame;
    clay.advance({}, {lower, upper}, frame);
    lower.pose = poseAfter(lower, frame), upper.pose = poseAfter(upper, frame);
  }
  /// N, of the clay on the upper plate
  static Eigen::Vector3d force(const Clay& clay) { return clay.solidForces()[1]; }

  Solid lower, upper;
};

}  // namespace tactile_clay::clay
