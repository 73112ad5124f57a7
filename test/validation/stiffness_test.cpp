#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rheology.h"
#include "support/samples.h"

/// Stiffness in Pa against formulas. Measured figures are in doc/method/validation.md.
namespace tactile_clay::clay::stiffness_test {
namespace {

class Stiffness : public ::testing::TestWithParam<Resolution> {};

/// Springs E d to 6 + 12 neighbours are an isotropic solid of Lame's lambda = mu = E, so of Young's modulus
/// 5/2 E. A bar has all of it although its surface lacks bonds. Without the density term, which would add to
/// it. Within 3 %.
TEST_P(Stiffness, GivesYoungsModulus) {
  Material springs = Bar::slippery(INFINITY);
  springs.bulk_modulus = 0.0;
  Bar bar(GetParam(), springs);
  const double young = bar.pressTo(0.01) / 0.01, expected = 2.5 * springs.stiffness;
  EXPECT_NEAR(young, expected, 0.03 * expected);
}

constexpr double yield = 0.02;  // of bonds that do

/// Below its yield strain a bar comes back.
TEST_P(Stiffness, GivesBackWhatDidNotYield) {
  Bar bar(GetParam(), Bar::slippery(yield));
  bar.pressTo(0.75 * yield);
  bar.pressTo(0.0);
  EXPECT_LT(bar.clayStrain(), 0.01 * 0.75 * yield);
}

/// Above its yield strain it keeps the strain beyond sigma / E, within 15 %.
TEST_P(Stiffness, KeepsWhatYielded) {
  Bar bar(GetParam(), Bar::slippery(yield));
  const double young = bar.pressTo(0.75 * yield) / (0.75 * yield);
  const double stress = bar.pressTo(6.0 * yield);
  bar.pressTo(0.0);
  const double expected = 6.0 * yield - stress / young;
  EXPECT_NEAR(bar.clayStrain(), expected, 0.15 * expected);
}

/// The shear modulus is `stiffness`; bonds that the surface of the cylinder lacks make it softer, by less
/// than d / R of the frequency.
TEST_P(Stiffness, IsTheShearModulus) {
  Material solid;
  solid.viscosity = 0.0;
  solid.stiffness = 1000.0;
  Twisted sample(GetParam(), solid, 0.01, false);
  const double dt = sample.timeStep();
  double before = sample.amplitude(), zero = 0.0;
  std::vector<double> zeros;
  while (zeros.size() < 2 && sample.clay->time() < 0.3) {
    sample.clay->advance({}, {}, dt);
    const double now = sample.amplitude();
    zero = sample.clay->time() - dt * now / (now - before);
    if ((now < 0.0) != (before < 0.0)) zeros.push_back(zero);
    before = now;
  }
  ASSERT_EQ(zeros.size(), 2u);
  const double expected = Twisted::wave_number * std::sqrt(solid.stiffness / solid.density);
  const double share = M_PI / (zeros[1] - zeros[0]) / expected;
  EXPECT_GT(share, 1.0 - GetParam().spacing / Twisted::radius);
  EXPECT_LT(share, 1.0);
}

/// The length of the step changes neither modulus nor memory: a sheared slab keeps its stress (there is no
/// relaxation below the yield stress; Maxwell's time is infinite).
TEST_P(Stiffness, DoesNotRelax) {
  Bar bar(GetParam(), Bar::slippery(0.02));
  const double first = bar.pressTo(0.015);
  EXPECT_GT(first, 0.015 * 2.0 * bar.clay.materials()[0].stiffness)
      << "Pa, of a Young's modulus of 2.2 E and more";
  for (int k = 0; k < 60; ++k) bar.plates.advance(bar.clay);
  EXPECT_NEAR(bar.stress(), first, 0.01 * first);
}
INSTANTIATE_TEST_SUITE_P(Rheology, Stiffness, ::testing::ValuesIn(resolutions()), nameOfResolution);

}  // namespace
}  // namespace tactile_clay::clay::stiffness_test
