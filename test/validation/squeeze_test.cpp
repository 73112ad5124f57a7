#include <gtest/gtest.h>

#include "support/samples.h"

/// Clay that is squeezed between two plates, as between fingers.
namespace tactile_clay::clay::squeeze_test {
namespace {

constexpr double radius = 0.06, thickness = 0.03, speed = 0.01;  // m, m, m/s

/// Mean force of the clay on the upper plate, N, from 0.05 to 0.1 s after it starts down, and the distance of
/// the layers that touch the plates, m, in the middle of that time.
std::pair<double, double> squeeze(const Resolution& resolution, const Material& material) {
  Clay clay(weightless(resolution), {material}, cylinder(radius, thickness, resolution.spacing));
  Plates plates(thickness, bite);
  plates.upper.linear_velocity.z() = -speed;
  double sum = 0.0;
  for (int k = 0; k < 6; ++k) {
    plates.advance(clay);
    if (k >= 3) sum += Plates::force(clay).z() / 3.0;
  }
  return {sum, thickness - resolution.spacing - 4.5 / 60.0 * speed};
}

class Squeeze : public ::testing::TestWithParam<Resolution> {};

/// Without friction: Trouton's viscosity, force V = 3 eta (V / h)^2 times the volume of the clay, exact for
/// an incompressible fluid. Layers that touch a plate are strained like all others, with their whole cells.
/// So the volume is that of all layers, while h is the distance between the outermost layers. Within 10 %.
TEST_P(Squeeze, OfAFluidBetweenSlipperyPlates) {
  Material fluid;
  fluid.stiffness = 0.0;
  fluid.friction = 0.0;
  const auto [force, h] = squeeze(GetParam(), fluid);
  const double expected = 3.0 * fluid.viscosity * speed / (h * h) * M_PI * radius * radius * thickness;
  EXPECT_NEAR(force, expected, 0.1 * expected);
}

/// Without slip: Stefan's 3 pi eta R^4 V / (2 h^3), for a thin film. At R / h of two and a half, stretching
/// adds at most Trouton's force; the upper limit includes it.
TEST_P(Squeeze, OfAFluidBetweenPlatesThatHoldIt) {
  const Material fluid = sticking(200.0, 0.0);
  const auto [force, h] = squeeze(GetParam(), fluid);
  const double stefan = 1.5 * M_PI * fluid.viscosity * std::pow(radius, 4.0) * speed / std::pow(h, 3.0);
  const double trouton = 3.0 * fluid.viscosity * speed / h * M_PI * radius * radius;
  RecordProperty("stefan", std::to_string(force / stefan));
  EXPECT_GT(force, 0.85 * stefan);
  EXPECT_LT(force, 1.15 * (stefan + trouton));
}

INSTANTIATE_TEST_SUITE_P(Plates, Squeeze, ::testing::ValuesIn(resolutions()), nameOfResolution);

}  // namespace
}  // namespace tactile_clay::clay::squeeze_test
