#include "clay/kernel.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "clay/lattice.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay::kernel_test {
namespace {

constexpr float h = 0.01f;

double integrateShells(double (*f)(const Kernel&, double)) {
  const Kernel kernel(h);
  constexpr int steps = 20000;
  double total = 0.0;
  for (int k = 0; k < steps; ++k) {
    const double r = h * (k + 0.5) / steps;
    total += f(kernel, r) * h / steps;
  }
  return total;
}

TEST(Kernel, IntegratesToOne) {
  const double total = integrateShells(
      [](const Kernel& w, double r) { return 4.0 * M_PI * r * r * w.value(static_cast<float>(r)); });
  EXPECT_NEAR(total, 1.0, 1e-5);
}

/// Over a lattice, the gradients cancel by symmetry, and r dW/dr integrates to -3 (by parts).
TEST(Kernel, GradientIntegratesToZeroAndItsFirstMomentToMinusIdentity) {
  const Kernel kernel(h);
  constexpr int cells = 24;
  const double step = 2.0 * h / (2 * cells + 1);
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (int x = -cells; x <= cells; ++x) {
    for (int y = -cells; y <= cells; ++y) {
      for (int z = -cells; z <= cells; ++z) {
        const Eigen::Vector3d r = step * Eigen::Vector3d(x, y, z);
        if (r.norm() == 0.0) continue;
        const Eigen::Vector3d g = kernel.slope(static_cast<float>(r.norm())) * r / r.norm();
        gradient += step * step * step * g;
        moment += step * step * step * r * g.transpose();
      }
    }
  }
  EXPECT_LT(gradient.norm() * h, 1e-5);
  EXPECT_TRUE(moment.isApprox(-Eigen::Matrix3d::Identity(), 2e-3)) << moment;
}

TEST(Kernel, SlopeIsTheDerivativeOfTheValue) {
  const Kernel kernel(h);
  // double precision oracle of the published piecewise form
  const auto value = [](double r) {
    const double q = r / h, sigma = 8.0 / (M_PI * std::pow(static_cast<double>(h), 3.0));
    if (q >= 1.0) return 0.0;
    return q <= 0.5 ? sigma * (6.0 * (q * q * q - q * q) + 1.0) : sigma * 2.0 * std::pow(1.0 - q, 3.0);
  };
  const double peak = value(0.0);
  for (double r = 1e-5; r < 1.2 * h; r += 1.7e-4) {
    EXPECT_NEAR(kernel.value(static_cast<float>(r)), value(r), 2e-6 * peak) << r;
    const double numerical = (value(r + 1e-7) - value(r - 1e-7)) / 2e-7;
    EXPECT_NEAR(kernel.slope(static_cast<float>(r)), numerical, 1e-5 * peak / h) << r;
  }
}

TEST(Kernel, VanishesBeyondTheSupportAndIsPositiveWithin) {
  const Kernel kernel(h);
  for (const float r : {h, 1.5f * h, 1e3f * h}) {
    EXPECT_EQ(kernel.value(r), 0.0f);
    EXPECT_EQ(kernel.slope(r), 0.0f);
  }
  for (float r = 0.01f * h; r < 0.99f * h; r += 0.01f * h) {
    EXPECT_GT(kernel.value(r), 0.0f);
    EXPECT_LT(kernel.slope(r), 0.0f);
  }
  EXPECT_FLOAT_EQ(kernel.value(0.0f), kernel.sigma);
}

TEST(Kernel, LanesGiveTheBitsOfSingleNumbers) {
  const Kernel kernel(h);
  Lane r;
  for (int k = 0; k < lane_width; ++k) r[k] = 0.0017f * static_cast<float>(k);
  const Lane value = kernel.value(r), slope = kernel.slope(r);
  for (int k = 0; k < lane_width; ++k) {
    EXPECT_EQ(value[k], kernel.value(r[k]));
    EXPECT_EQ(slope[k], kernel.slope(r[k]));
  }
}

TEST(Kernel, LatticeSumIsCloseToTheNumberDensity) {
  const float spacing = 0.5f * h;
  EXPECT_NEAR(latticeSum(Kernel(h), spacing) * std::pow(spacing, 3.0f), 1.0f, 0.02f);
}

}  // namespace
}  // namespace tactile_clay::clay::kernel_test
