#include "ultrasound/slip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>

namespace tactile_clay::ultrasound::slip_test {
namespace {

contact::PressureSample sample(float pressure, float slip) {
  return {{0, 0, 0.2f}, {0, 0, -1}, pressure, pressure * 1e-5f, 1e-5f, 1.0f, slip};
}

/// Fourier coefficient of the wave, over one second.
double line(double frequency) {
  constexpr int steps = 6000;
  std::complex<double> sum = 0.0;
  for (int k = 0; k < steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    sum += slipWave(t) * std::polar(1.0 / steps, -2.0 * M_PI * frequency * t);
  }
  return std::abs(sum);
}

// Morisaki et al. 2026, arXiv 2601.16767: 30 and 150 Hz, and here nothing else but the mean.
TEST(Slip, VibratesAtThePublishedFrequenciesAlone) {
  EXPECT_NEAR(line(0.0), slip_mean, 1e-9);
  EXPECT_NEAR(line(30.0), 0.125, 1e-9) << "half of 1/4";
  EXPECT_NEAR(line(150.0), 0.125, 1e-9);
  for (const double other : {10.0, 60.0, 90.0, 120.0, 180.0, 200.0, 300.0})
    EXPECT_NEAR(line(other), 0.0, 1e-9) << other;
}

TEST(Slip, NeverExceedsWhatIsThereWithoutIt) {
  for (double t = 0.0; t < 0.1; t += 1e-4) {
    ASSERT_GE(slipWave(t), -1e-12);
    ASSERT_LE(slipWave(t), 1.0 + 1e-12);
    for (const double slip : {0.0, 0.3, 1.0})
      for (const double amplitude : {0.0, 0.6, 1.0}) {
        const double mixed = withSlip(amplitude, slip, std::max(slipWave(t), 0.0));
        ASSERT_LE(mixed, 1.0 + 1e-12);
        ASSERT_NEAR(mixed * mixed, (1.0 - slip) * amplitude * amplitude + slip * slipWave(t), 1e-12);
      }
  }
}

TEST(Slip, ShareIsThatOfTheForceUnderWhichClaySlides) {
  EXPECT_EQ(slipShare({}, 10.0), 0.0);
  EXPECT_EQ(slipShare({sample(1000, 0.05f)}, 0.0), 0.0);
  EXPECT_NEAR(slipShare({sample(1000, 0.05f)}, 10.0), 0.5, 1e-6);
  EXPECT_NEAR(slipShare({sample(1000, 5.0f)}, 10.0), 1.0, 1e-6) << "all of it, at most";
  EXPECT_NEAR(slipShare({sample(3000, 0.0f), sample(1000, 0.2f)}, 10.0), 0.25, 1e-6);
  EXPECT_NEAR(slipShare({sample(0, 1.0f), sample(1000, 0.0f)}, 10.0), 0.0, 1e-6) << "bare skin has none";
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NEAR(slipShare({sample(nan, 1.0f), sample(1000, nan), sample(1000, 0.1f)}, 10.0), 1.0, 1e-6);
  EXPECT_EQ(slipShare({sample(1000, -1.0f)}, 10.0), 0.0);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::slip_test
