#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rheology.h"
#include "support/samples.h"

/// Viscosity in Pa s against formulas. Measured figures are in doc/method/validation.md.
namespace tactile_clay::clay::viscosity_test {
namespace {

class Viscosity : public ::testing::TestWithParam<Resolution> {};

/// Within 5 %, by which the dashpots of the lattice differ between directions. It is compared with the decay
/// of implicit Euler, 1 / (1 + rate dt) per step, so that the error of the step does not count.
TEST_P(Viscosity, DampsATwistAtItsRate) {
  for (const bool turned : {false, true}) {
    for (const double eta : {20.0, 200.0}) {
      Material fluid;
      fluid.viscosity = eta;
      fluid.stiffness = 0.0;
      Twisted sample(GetParam(), fluid, 0.2, turned);
      const double first = sample.amplitude();
      const int steps = 4;
      for (int k = 0; k < steps; ++k) sample.clay->advance({}, {}, sample.timeStep());
      const double rate = (std::pow(first / sample.amplitude(), 1.0 / steps) - 1.0) / sample.timeStep();
      const double measured = rate * fluid.density / std::pow(Twisted::wave_number, 2.0);
      EXPECT_NEAR(measured, eta, 0.05 * eta) << (turned ? "turned lattice" : "lattice");
    }
  }
}

/// Steady: u(y) = (rho g / eta)(H y - y^2 / 2). The speed of the surface is of first order, within d / H.
TEST_P(Viscosity, LetsAFilmFlow) {
  constexpr double gravity = 5.0;
  const Material fluid = sticking(200.0, 0.0);
  Film film(GetParam(), fluid, gravity);
  film.run(6);
  const double scale = fluid.density * gravity / fluid.viscosity, height = film.height;
  EXPECT_NEAR(film.profile().back(), 0.5 * scale * height * height, 0.5 * scale * height * film.d);
}

/// In the middle half of its height the shear rate is within 5 %, by which the viscosity of a lattice may
/// depend on its direction. The film is ten times as long as it is thick: at a third of that, the ends change
/// the rate by 2 to 12 %. It is wide, because columns at its sides are too viscous
/// (doc/method/validation.md).
TEST_P(Viscosity, ShearsAFilmAtItsRate) {
  constexpr double gravity = 5.0;
  const Material fluid = sticking(200.0, 0.0);
  Film film(GetParam(), fluid, gravity, {0.45, 0.12});
  film.run(6);
  const std::vector<double> u = film.profile();
  for (int k = film.layers / 4; k + 1 < 3 * film.layers / 4; ++k) {
    const double expected = fluid.density * gravity / fluid.viscosity * (film.height - (k + 0.5) * film.d);
    EXPECT_NEAR((u[k + 1] - u[k]) / film.d, expected, 0.05 * expected) << "layer " << k;
  }
}

/// Started up: the surface's share of its final speed is 1 - (32 / pi^3) sum (-1)^n / (2 n + 1)^3 exp(-((2 n
/// + 1) pi / 2)^2 eta t / (rho H^2)) (Bird, Stewart & Lightfoot, Transport Phenomena), within 10 % of the
/// final speed.
void startsUp(const Resolution& resolution) {
  constexpr double gravity = 2.0;
  const Material fluid = sticking(20.0, 0.0);
  Film film(resolution, fluid, gravity);
  const double diffusion = fluid.density * film.height * film.height / fluid.viscosity;  // s
  const double final = 0.5 * fluid.density * gravity * film.height * film.height / fluid.viscosity;
  while (film.clay.time() < diffusion) {
    film.run(1);
    double share = 1.0;
    for (int n = 0; n < 8; ++n) {
      const double a = 2.0 * n + 1.0;
      share -= 32.0 / std::pow(M_PI, 3.0) * (n % 2 == 0 ? 1.0 : -1.0) / std::pow(a, 3.0) *
               std::exp(-std::pow(0.5 * a * M_PI, 2.0) * film.clay.time() / diffusion);
    }
    EXPECT_NEAR(film.profile().back() / final, share, 0.1) << "after " << film.clay.time() << " s";
  }
}
TEST(FilmStartUp, Converged) {
  startsUp({{16, 64}, 0.005});
}
/// Eight iterations alone carry the friction of the wall, but not the whole weight, through nine layers:
/// without the motion of cubes the film is a fifth too slow while it starts.
TEST(FilmStartUp, Balanced) {
  startsUp({{4, 8}, 0.005});
}

/// Couette's flow: the stress is eta times the shear rate, within 5 %, on average over the arrangements of
/// the lattice that a shear by one half passes through.
TEST_P(Viscosity, ResistsSimpleShear) {
  const Material fluid = sticking(200.0, 0.0);
  SimpleShear shear(GetParam(), fluid, 2.0);
  shear.shearTo(0.1);
  EXPECT_NEAR(shear.shearTo(0.6), fluid.viscosity * 2.0, 0.05 * fluid.viscosity * 2.0);
}

INSTANTIATE_TEST_SUITE_P(Rheology, Viscosity, ::testing::ValuesIn(resolutions()), nameOfResolution);

}  // namespace
}  // namespace tactile_clay::clay::viscosity_test
