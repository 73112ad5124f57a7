#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "clay/forces/potential.h"
#include "potential_cloud.h"

/// Viscosity of a sheared lattice, in Pa s.
namespace tactile_clay::clay::potential_viscosity_test {
namespace {

using namespace potential_cloud;

/// Power that shears a cube of the initial lattice in a step of `step` s, over eta gamma^2 volume.
double shearPower(int side, const Eigen::Matrix3f& turn, float step) {
  std::vector<Material> materials{viscosity_only};
  const Kernel kernel(2.0f * spacing);
  Potential potential(kernel, spacing, materials);
  const Particles particles = particlesAt(lattice(side, spacing, 0.0f), 2e-4f);
  Neighbourhood near(kernel.h);
  near.build(particles.position);
  const double volume = static_cast<double>(particles.size()) * std::pow(static_cast<double>(spacing), 3.0);
  const float rate = 0.1f;  // 1/s
  VectorField u = zeros(particles.size()), f = u;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Eigen::Vector3f local = turn.transpose() * particles.position.at(i);
    u.set(i, turn * Eigen::Vector3f(rate * step * local.z(), 0.0f, 0.0f));
  }
  const VectorField rest = zeros(particles.size());
  Compression at;
  at.resize(particles.size());
  StepPotential linear;
  potential.linearise({near, particles, nullptr, rest, step}, {}, linear);
  linear.startForce(u, f, at).add(0, u.size());
  double watts = 0.0;
  for (std::size_t i = 0; i < particles.size(); ++i)
    watts -= f.at(i).dot(u.at(i)) / static_cast<double>(step);
  return watts / (viscosity_only.viscosity * rate * rate * volume);
}

/// A Newtonian fluid in simple shear takes eta gamma^2 watts per cubic metre, whatever the step. Averaged
/// over directions this is exact, at surfaces as well as inside.
TEST(Potential, ViscosityIsInPascalSeconds) {
  for (const float step : {1e-3f, 1e-2f}) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    double mean = 0.0;
    const int turns = 300;
    for (int k = 0; k < turns; ++k) {
      const Eigen::Quaternionf turn(normal(random), normal(random), normal(random), normal(random));
      mean += shearPower(4, turn.normalized().toRotationMatrix(), step) / turns;
    }
    EXPECT_NEAR(mean, 1.0, 0.02) << step;
  }
}

/// The lattice of the start is cubic, not isotropic. The part of the faces of a cube falls with its size, and
/// is eliminated with two sizes.
TEST(Potential, ViscosityIsNearlyIsotropicInside) {
  const Eigen::Matrix3f along_axes = Eigen::Matrix3f::Identity();
  const Eigen::Matrix3f along_diagonals =
      Eigen::AngleAxisf(static_cast<float>(M_PI) / 4.0f, Eigen::Vector3f::UnitY()).toRotationMatrix();
  for (const Eigen::Matrix3f& turn : {along_axes, along_diagonals}) {
    const double inside = (16.0 * shearPower(16, turn, 1e-2f) - 6.0 * shearPower(6, turn, 1e-2f)) / 10.0;
    EXPECT_NEAR(inside, 1.0, 0.05);
  }
}

}  // namespace
}  // namespace tactile_clay::clay::potential_viscosity_test
