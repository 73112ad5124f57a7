#include "ultrasound/perceptual_weight.h"

#include <gtest/gtest.h>

#include <limits>

namespace tactile_clay::ultrasound::perceptual_weight_test {
namespace {

double mean(double from, double to) {
  constexpr int n = 1000;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += perceptualWeight(from + (to - from) * (i + 0.5) / n);
  return sum / n;
}

TEST(PerceptualWeight, FollowsMechanoreceptorDensities) {
  // Relative densities palm : finger : fingertip 1 : 1.6 : 4.2 (Johansson & Vallbo 1979), within 5 %.
  EXPECT_DOUBLE_EQ(mean(0.0, 0.008), 1.0);
  EXPECT_NEAR(mean(0.015, 0.065), 1.6 / 4.2, 0.05 * 1.6 / 4.2);
  EXPECT_NEAR(mean(0.080, 0.160), 1.0 / 4.2, 0.05 * 1.0 / 4.2);
}

TEST(PerceptualWeight, FallsSmoothlyWithDistance) {
  // Largest slope of 1 / (1 + x^2) is 0.65 per decay length: steps of 0.1 mm change it by less than 0.5 %.
  double slope = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double d = i * 1e-4;
    const double next = (perceptualWeight(d) - perceptualWeight(d + 1e-4)) / 1e-4;
    EXPECT_GE(next, 0.0) << d;
    EXPECT_LT(next * 1e-4, 5e-3) << d;
    EXPECT_LT(std::abs(next - slope) * 1e-4, 1.5e-4) << d;  // the slope has no jump
    slope = next;
  }
}

TEST(PerceptualWeight, OfAnUnknownDistanceIsThePalms) {
  EXPECT_DOUBLE_EQ(perceptualWeight(std::numeric_limits<double>::quiet_NaN()), 58.0 / 241.0);
  EXPECT_DOUBLE_EQ(perceptualWeight(std::numeric_limits<double>::infinity()), 58.0 / 241.0);
  EXPECT_DOUBLE_EQ(perceptualWeight(-1.0), 1.0);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::perceptual_weight_test
