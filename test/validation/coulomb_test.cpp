#include <gtest/gtest.h>

#include <tuple>

#include "support/setups.h"

/// Coulomb's law on a slab of clay: it rests iff tan(slope) < mu, and slides with g (sin - mu cos).
namespace tactile_clay::clay::coulomb_test {
namespace {

constexpr double g = 9.81, degree = M_PI / 180.0;

struct Slab {
  Slab(double mu, double slope_in, Budget budget, double speed = 0.0) : slope(slope_in) {
    ClayConfig config;
    config.budget = budget;
    config.threads = 2;
    Material m;
    m.friction = mu;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(slope, Eigen::Vector3d::UnitY()).toRotationMatrix();
    auto particles = block(8, 8, 3, config.spacing, Eigen::Vector3d::Zero(), turn);
    for (InitialParticle& p : particles) p.velocity = (speed * turn.col(0)).cast<float>();
    down = turn.col(0);
    clay = std::make_unique<Clay>(config, std::vector<Material>{m}, particles);
    start = position();
  }
  void run(double seconds) {
    for (int k = 0; k < std::lround(60.0 * seconds); ++k) clay->advance({}, {ground(slope)}, 1.0 / 60.0);
  }
  double position() const { return down.dot(centreOfMass(clay->particles())); }
  double speed() const { return down.dot(momentum(clay->particles())) / totalMass(clay->particles()); }

  double slope;
  Eigen::Vector3d down;
  std::unique_ptr<Clay> clay;
  double start = 0.0;
};

class Coulomb : public ::testing::TestWithParam<std::tuple<std::pair<int, int>, double>> {
 protected:
  Budget budget() const { return {std::get<0>(GetParam()).first, std::get<0>(GetParam()).second}; }
  double mu() const { return std::get<1>(GetParam()); }
};

TEST_P(Coulomb, RestsTwoDegreesBelowTheFrictionAngle) {
  Slab slab(mu(), std::atan(mu()) - 2.0 * degree, budget());
  slab.run(1.0);
  EXPECT_LT(slab.position() - slab.start, 1e-3);
  EXPECT_LT(meanSpeed(slab.clay->particles()), 1e-4);
}

TEST_P(Coulomb, SlidesTwoDegreesAboveTheFrictionAngleAsItShould) {
  for (const double above : {2.0, 6.0}) {
    const double slope = std::atan(mu()) + above * degree;
    Slab slab(mu(), slope, budget());
    slab.run(0.3);
    const double before = slab.speed();
    slab.run(0.3);
    const double expected = g * (std::sin(slope) - mu() * std::cos(slope));
    EXPECT_NEAR((slab.speed() - before) / 0.3, expected, 0.05 * expected) << above << " degrees above";
  }
}

std::string nameOf(const ::testing::TestParamInfo<std::tuple<std::pair<int, int>, double>>& tested) {
  const auto [budget, mu] = tested.param;
  return std::to_string(budget.first) + "x" + std::to_string(budget.second) + "Mu0" +
         std::to_string(std::lround(10.0 * mu));
}
INSTANTIATE_TEST_SUITE_P(Grid, Coulomb,
                         ::testing::Combine(::testing::Values(std::pair{4, 8}, std::pair{8, 16}),
                                            ::testing::Values(0.3, 0.6)),
                         nameOf);

TEST(CoulombFlat, StopsAfterVSquaredOverTwoMuG) {
  constexpr double mu = 0.4, speed = 0.6;
  Slab slab(mu, 0.0, {8, 16}, speed);
  slab.run(0.5);
  const double expected = speed * speed / (2.0 * mu * g);
  EXPECT_NEAR(slab.position() - slab.start, expected, 0.05 * expected);
  EXPECT_LT(meanSpeed(slab.clay->particles()), 1e-4);
}

TEST(CoulombFlat, StopsAfterVSquaredOverTwoMuGAtBalanced) {
  constexpr double mu = 0.4, speed = 0.6;
  Slab slab(mu, 0.0, {4, 8}, speed);
  slab.run(0.5);
  const double expected = speed * speed / (2.0 * mu * g);
  EXPECT_NEAR(slab.position() - slab.start, expected, 0.05 * expected);
}

}  // namespace
}  // namespace tactile_clay::clay::coulomb_test
