#pragma once

#include <gtest/gtest.h>

#include <cmath>
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

inline std::string nameOfResolution(const ::testing::TestParamInfo<Resolution>& tested) {
  return nameOf(tested.param);
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
  m.viscosity = viscosity;
  m.stiffness = stiffness;
  m.friction = 10.0;
  m.adhesion = 1e5;
  return m;
}

/// Pa, in shear: a bond's strain is half of the shear along a diagonal.
inline double yieldStress(const Material& m) {
  return 2.0 * m.stiffness * m.yield_strain;
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

constexpr double bite = 2e-5;  // m, that plates are in the clay at first

/// Two level plates. The lower one has its face at z = 0, the upper one at `height`; `overlap` of each is in
/// the clay, so that contacts close in the first step.
struct Plates {
  explicit Plates(double height, double overlap = 0.0) {
    lower.size = upper.size = {1.0, 1.0, 0.1};
    lower.pose.translation().z() = -0.1 + overlap;
    upper.pose.translation().z() = height + 0.1 - overlap;
  }
  /// Moves both for a frame.
  void advance(Clay& clay) {
    const double frame = clay.config().frame;
    clay.advance({}, {lower, upper}, frame);
    lower.pose = poseAfter(lower, frame);
    upper.pose = poseAfter(upper, frame);
  }
  /// N, of the clay on the upper plate
  static Eigen::Vector3d force(const Clay& clay) { return clay.solidForces()[1]; }

  Solid lower, upper;
};

/// Clay sheared between two plates that hold it.
struct SimpleShear {
  static constexpr double length = 0.12, width = 0.03, thickness = 0.03;

  SimpleShear(const Resolution& r, const Material& material, double rate_in)
      : rate(rate_in),
        gap(thickness - r.spacing),
        clay(weightless(r), {material},
             moving(block(count(length, r), count(width, r), count(thickness, r), r.spacing))),
        plates(thickness, bite) {
    plates.upper.linear_velocity.x() = 0.5 * rate * gap;
    plates.lower.linear_velocity.x() = -0.5 * rate * gap;
  }
  static int count(double size, const Resolution& r) {
    return static_cast<int>(std::lround(size / r.spacing));
  }
  std::vector<InitialParticle> moving(std::vector<InitialParticle> particles) const {
    for (InitialParticle& p : particles)
      p.velocity.x() = static_cast<float>(rate * (static_cast<double>(p.position.z()) - 0.5 * thickness));
    return particles;
  }
  /// Shears on to a strain.
  /// @return Pa, mean shear stress on the way
  double shearTo(double to) {
    const int frames = static_cast<int>(std::lround((to - strain) / rate / clay.config().frame));
    double sum = 0.0;
    for (int k = 0; k < frames; ++k) {
      plates.advance(clay);
      sum -= Plates::force(clay).x() / (length * width);
    }
    strain = to;
    return sum / frames;
  }

  double rate, gap, strain = 0.0;
  Clay clay;
  Plates plates;
};

}  // namespace tactile_clay::clay
