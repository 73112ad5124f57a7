#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clay/forces/potential.h"
#include "potential_cloud.h"

/// How much of a compression pushes, is kept, and is undone.
namespace tactile_clay::clay::potential_compression_test {
namespace {

using namespace potential_cloud;

/// Density gives back no more of a compression than the last step left, plus the kinetic energy of 0.5 m/s.
TEST(Potential, CompressionBeyondThatOfTheLastStepPushesLittle) {
  Cloud s(density_only, 0.93f);
  const VectorField rest = zeros(s.size());
  const std::vector<float> ratio = s.densityRatio();
  const auto energy = [&](float share) {  // J, of the most compressed
    for (std::size_t i = 0; i < s.size(); ++i)
      s.particles.compression[i] = share * std::max(ratio[i] - 1.0f, 0.0f);
    s.linearise(rest);
    s.forceAt(rest);
    const double stiffness = density_only.bulk_modulus * std::pow(spacing, 3.0);
    double maximum = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i)
      maximum = std::max(maximum, 0.5 * stiffness * std::pow(s.state.acting(i), 2.0));
    return maximum;
  };
  const double whole = energy(1.0f), of_half_a_metre_a_second = 0.5 * 0.25 / s.particles.inverse_mass[0];
  ASSERT_GT(whole, 2.0 * of_half_a_metre_a_second);
  EXPECT_NEAR(energy(0.5f), 0.25 * whole + of_half_a_metre_a_second, 1e-4 * whole);
  EXPECT_NEAR(energy(0.0f), of_half_a_metre_a_second, 1e-4 * whole);
}

/// The energy that a particle was lent for this is taken back at the end of the step, except the kinetic
/// energy of 0.1 m/s. Otherwise a particle that others keep squeezed would be lent it again and again.
TEST(Potential, CompressionThatWasLentIsNotKept) {
  Cloud s(density_only, 0.93f);
  const VectorField rest = zeros(s.size());
  const double stiffness = density_only.bulk_modulus * std::pow(spacing, 3.0);
  const double kept = 0.5 * 0.01 / s.particles.inverse_mass[0];  // J
  const std::vector<float> ratio = s.densityRatio();
  const auto maximum = std::max_element(ratio.begin(), ratio.end()) - ratio.begin();
  const float whole = ratio[maximum] - 1.0f;
  s.particles.compression[maximum] = 0.5f * whole;
  for (int k = 1; k <= 5; ++k) {
    s.linearise(rest);
    s.forceAt(rest);
    const double paid = s.paid(maximum);
    EXPECT_NEAR(0.5 * stiffness * (paid * paid - 0.25 * whole * whole), k * kept, 0.01 * kept);
    EXPECT_LT(paid, s.state.acting(maximum));
    s.particles.compression[maximum] = static_cast<float>(paid);
  }
}

/// Clay that is pressed to many times its density, as between palms that leave no room, gives back no more
/// than clay that is pressed to twice its density.
TEST(Potential, CompressionIsKeptUpToTwiceTheDensity) {
  Cloud s(density_only, 0.6f);
  const VectorField rest = zeros(s.size());
  const std::vector<float> ratio = s.densityRatio();
  for (std::size_t i = 0; i < s.size(); ++i) s.particles.compression[i] = std::max(ratio[i] - 1.0f, 0.0f);
  s.linearise(rest);
  s.forceAt(rest);
  int more = 0, less = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    (ratio[i] > 2.01f ? more : less) += 1;
    EXPECT_NEAR(s.state.acting(i), std::max(ratio[i] - 1.0f, 0.0f), 2e-3f * ratio[i]) << i;
    EXPECT_NEAR(s.paid(i), std::clamp(ratio[i] - 1.0f, 0.0f, 1.0f), 2e-3f) << i;
  }
  EXPECT_GT(more, 10);
  EXPECT_GT(less, 10);
}

/// Compression that may not push is undone by displacements whose sum is zero.
TEST(Potential, CompressionBeyondThatOfTheLastStepIsUndone) {
  Cloud s(density_only, 0.93f);
  std::fill(s.particles.compression.begin(), s.particles.compression.end(), 0.0f);
  const auto compression = [&] {
    double total = 0.0;
    for (const float ratio : s.densityRatio()) total += std::max(ratio - 1.0f, 0.0f);
    return total;
  };
  const VectorField rest = zeros(s.size());
  VectorField w = rest;
  const double before = compression();
  for (int k = 0; k < 100; ++k) {
    s.near.build(s.particles.position);
    s.linearise(rest);
    ASSERT_EQ(s.step.excessive, k == 0 || compression() > 0.0);
    s.step.recover(s.state, w);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double farthest = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      sum += w.at(i).cast<double>();
      farthest = std::max<double>(farthest, w.at(i).norm());
      s.particles.position[i] += w[i];
    }
    EXPECT_LE(sum.norm(), 1e-6 * farthest * static_cast<double>(s.size()));
    EXPECT_LT(farthest, 0.5 * dt);
  }
  EXPECT_LT(compression(), 0.2 * before);
}

/// Gradients are those at the start of the step; in a long step 0.5 m/s would move particles many spacings
/// along them.
TEST(Potential, CompressionIsUndoneByHalfASpacingAStepAtMost) {
  constexpr float long_step = 0.1f;
  std::vector<Eigen::Vector3f> points = lattice(3, 1e-3f * spacing, 0.0f);
  Cloud s(density_only, 1.0f);
  s.particles = particlesAt(points, 2e-4f);
  std::fill(s.particles.compression.begin(), s.particles.compression.end(), 0.0f);
  const VectorField rest = zeros(points.size());
  VectorField w = rest;
  s.near.build(s.particles.position);
  s.linearise(rest, long_step);
  ASSERT_TRUE(s.step.excessive);
  s.step.recover(s.state, w);
  double farthest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) farthest = std::max<double>(farthest, w.at(i).norm());
  EXPECT_GT(farthest, 0.01 * spacing);
  EXPECT_LT(farthest, 2.0 * spacing);
}

/// As in a closing fist: each particle undoes as much as it can, and all this adds up.
TEST(Potential, CompressionOfManyInOnePlaceIsUndoneByNoLeap) {
  const std::vector<Eigen::Vector3f> points = lattice(6, 0.1f * spacing, 0.0f);
  Cloud s(density_only, 1.0f);
  s.particles = particlesAt(points, 2e-4f);
  std::fill(s.particles.compression.begin(), s.particles.compression.end(), 0.0f);
  const VectorField rest = zeros(points.size());
  s.near.build(s.particles.position);
  for (const float step : {0.1f, 0.004f}) {
    VectorField w = rest;
    s.linearise(rest, step);
    ASSERT_TRUE(s.step.excessive);
    s.step.recover(s.state, w);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_LE(w.at(i).norm(), 1.001f * std::min(spacing, 1.0f * step));  // 1 m/s
  }
}

}  // namespace
}  // namespace tactile_clay::clay::potential_compression_test
