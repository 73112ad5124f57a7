#include "ultrasound/acoustics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace tactile_clay::ultrasound::acoustics_test {
namespace {

TEST(Acoustics, DirectivityIsThatOfAPiston) {
  EXPECT_DOUBLE_EQ(pistonDirectivity(0.0), 1.0);
  for (int i = 1; i <= 400; ++i) {
    const double x = 0.01 * i;
    EXPECT_NEAR(pistonDirectivity(x * x), 2.0 * std::cyl_bessel_j(1.0, x) / x, 1e-6) << x;
    EXPECT_NEAR(pistonDirectivity(static_cast<float>(x * x)), 2.0 * std::cyl_bessel_j(1.0, x) / x, 2e-6) << x;
  }
  // First zero of J1 at 3.8317: the edge of the main lobe.
  EXPECT_NEAR(pistonDirectivity(3.8317 * 3.8317), 0.0, 1e-5);
}

TEST(Acoustics, SpeedOfSoundFollowsTheTemperature) {
  Acoustics air;
  EXPECT_NEAR(air.soundSpeed(), 343.2, 0.2);  // 20 degrees C
  EXPECT_NEAR(air.wavelength(), 8.58e-3, 0.01e-3);
  air.temperature = 25.0;
  EXPECT_NEAR(air.soundSpeed(), 346.1, 0.2);
  EXPECT_NEAR(air.wavelength(), 8.65e-3, 0.01e-3);
  air.temperature = 0.0;
  EXPECT_NEAR(air.soundSpeed(), 331.3, 1e-9);
  EXPECT_NEAR(air.airDensity(), 1.292, 0.002);
  EXPECT_NEAR(air.wavenumber() * air.wavelength(), 2.0 * M_PI, 1e-12);
}

TEST(Acoustics, RadiationPressureOfTheTable) {
  // 2 p_rms^2 / (rho c^2) of 5013, 4305, 3623 and 2659 Pa peak: 178, 131, 93 and 50 Pa, within 2 %.
  const Acoustics air;
  EXPECT_NEAR(radiationPressure(air, 5013.0), 178.0, 3.6);
  EXPECT_NEAR(radiationPressure(air, 4305.0), 131.0, 2.6);
  EXPECT_NEAR(radiationPressure(air, 3623.0), 93.0, 1.9);
  EXPECT_NEAR(radiationPressure(air, 2659.0), 50.0, 1.0);
}

TEST(Acoustics, SoundPressureLevel) {
  EXPECT_NEAR(soundPressureLevel(std::sqrt(2.0)), 93.98, 0.01);  // 1 Pa rms
  EXPECT_NEAR(soundPressureLevel(10.0 * std::sqrt(2.0)), 113.98, 0.01);
  EXPECT_EQ(soundPressureLevel(0.0), 0.0);
}

TEST(Acoustics, RefusesBadParametersByName) {
  const auto message = [](auto change) {
    Acoustics air;
    change(air);
    try {
      air.validate();
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](auto&) {}), "accepted");
  EXPECT_EQ(message([](auto& a) { a.frequency = 0.0; }),
            "acoustics: frequency (Hz): expected a finite number above 0, got 0");
  EXPECT_NE(message([](auto& a) { a.temperature = std::nan(""); }).find("temperature"), std::string::npos);
  EXPECT_NE(message([](auto& a) { a.attenuation = -1.0; }).find("attenuation"), std::string::npos);
  EXPECT_NE(message([](auto& a) { a.transducer_radius = 0.008; }).find("transducer_radius"),
            std::string::npos);
  EXPECT_NE(message([](auto& a) { a.reference_pressure = -3.4; }).find("reference_pressure"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::acoustics_test
