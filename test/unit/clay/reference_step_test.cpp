#include "support/reference_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/setups.h"

namespace tactile_clay::clay::reference_step_test {
namespace {

constexpr double spacing = 0.005;

struct Case {
  const char* name;
  double viscosity, stiffness, bulk_modulus;
};
class ReferenceStep : public testing::TestWithParam<Case> {};

/// Two steps of a squeezed, stirred block in free fall, solved to the end. The tolerance is 1e-3 of the
/// change of displacements by internal forces. This is five times the rounding of lengths in single
/// precision.
TEST_P(ReferenceStep, IsWhatTheSolverConvergesTo) {
  Material material;
  material.viscosity = GetParam().viscosity;
  material.stiffness = GetParam().stiffness;
  material.bulk_modulus = GetParam().bulk_modulus;
  std::mt19937 random(7);
  std::normal_distribution<float> jitter(0.0f, 1.0f);
  auto particles = block(5, 4, 4, spacing);
  for (InitialParticle& p : particles) {
    p.position *= 0.98f;
    for (int a = 0; a < 3; ++a) {
      p.position[a] += 2e-4f * jitter(random);
      p.velocity[a] = 0.02f * jitter(random);
    }
  }
  ClayConfig config;
  config.spacing = spacing;
  config.threads = 1;
  config.budget = {4, 4000};
  config.tolerance = 0.0;
  Clay clay(config, {material}, particles);
  const double dt = config.frame / 4.0;
  for (int step = 0; step < 2; ++step) {
    const Sculpture before = clay.sculpture();
    clay.advance({}, {}, dt);
    const Sculpture after = clay.sculpture();
    const Vectors expected = referenceStep(before, after, material, config.gravity, dt, 4000, 400);
    double worst = 0.0, internal = 0.0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Eigen::Vector3d free = dt * before.velocity.at(i).cast<double>() + dt * dt * config.gravity;
      const Eigen::Vector3d moved = dt * after.velocity.at(i).cast<double>();
      worst = std::max(worst, (moved - expected[i]).norm());
      internal = std::max(internal, (expected[i] - free).norm());
    }
    if (step == 0) {  // later, density alone has nothing left to drive apart
      EXPECT_GT(internal, 1e-6);
    }
    EXPECT_LT(worst, 1e-3 * internal + 1e-9)
        << "step " << step << ", internal forces move by " << internal << " m";
  }
}

INSTANTIATE_TEST_SUITE_P(Clay, ReferenceStep,
                         testing::Values(Case{"viscosity", 200.0, 0.0, 0.0}, Case{"bonds", 0.0, 1e5, 0.0},
                                         Case{"density", 0.0, 0.0, 1e6}, Case{"all", 200.0, 1e5, 1e6}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace tactile_clay::clay::reference_step_test
