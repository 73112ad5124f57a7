#include <random>

#include "watch.h"

/// Cubes in time steps so coarse that gravity alone would move them by many spacings in one step. Starts are
/// shaken a little, so that no two contacts close at the same time.
namespace tactile_clay::clay::coarse_steps_test {
namespace {

/// A cube above the table by `above` spacings, its particles lifted and shifted at random.
Trial shakenCube(int edge, double spacing, double step, double above, unsigned seed) {
  Trial t;
  t.config.spacing = spacing;
  t.config.threads = 1;
  t.config.sleeping = false;
  t.config.budget = {1, 8};
  t.config.frame = step;
  t.particles = block(edge, edge, edge, spacing, {0.0, 0.0, above * spacing});
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> shake(-1.0f, 1.0f);
  const float shaken = static_cast<float>(2e-4 * spacing);
  for (InitialParticle& p : t.particles)
    p.position += shaken * Eigen::Vector3f(shake(random), shake(random), 1.0f + shake(random));
  return t;
}

struct Cube {
  double step, spacing;  // s, m
  int edge;              // particles
};
std::string nameOf(const ::testing::TestParamInfo<Cube>& tested) {
  const Cube& c = tested.param;
  return std::to_string(std::lround(1e3 * c.step)) + "ms" + std::to_string(std::lround(1e6 * c.spacing)) +
         "um" + std::to_string(c.edge) + "AnEdge";
}
std::vector<Cube> cubes() {
  std::vector<Cube> all;
  for (const double step : {1.0 / 60.0, 0.033, 0.05, 0.1})
    for (const double spacing : {0.001, 0.005, 0.05})
      for (const int edge : {3, 5, 6}) all.push_back({step, spacing, edge});
  return all;
}

class CoarseCube : public ::testing::TestWithParam<Cube> {};

/// Stands: from the first step on no particle moves by more than a hundredth of a spacing beyond three times
/// the compression of the cube under its weight (rho g H / E of its height). In the end its kinetic energy is
/// less than 1e-6 of the energy of a fall by a spacing.
TEST_P(CoarseCube, Stands) {
  const auto [step, spacing, edge] = GetParam();
  const double height = edge * spacing;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Trial t = shakenCube(edge, spacing, step, 0.0, seed);
    Clay clay(t.config, t.materials, t.particles);
    const Particles& p = clay.particles();
    const Material& m = t.materials[0];
    const double gives = 3.0 * m.density * 9.81 * height / m.stiffness * height + 0.01 * spacing;
    double farthest = 0.0;
    for (int k = 0; k < 60; ++k) {
      clay.advance({}, {ground()}, step);
      for (std::size_t i = 0; i < p.size(); ++i)
        farthest =
            std::max(farthest, static_cast<double>((p.position.at(i) - t.particles[i].position).norm()));
    }
    EXPECT_LE(farthest, gives);
    EXPECT_LE(kineticEnergy(p), 1e-6 * totalMass(p) * 9.81 * spacing);
  }
}

/// Set down from a spacing above, it gains no energy and comes to rest.
TEST_P(CoarseCube, ComesToRest) {
  const auto [step, spacing, edge] = GetParam();
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Trial t = shakenCube(edge, spacing, step, 1.0, seed);
    t.frames = 120;
    watch(t);
    Clay clay(t.config, t.materials, t.particles);
    const Particles& p = clay.particles();
    for (int k = 0; k < t.frames; ++k) clay.advance({}, {ground()}, step);
    EXPECT_LE(kineticEnergy(p), 1e-6 * totalMass(p) * 9.81 * spacing);
  }
}
INSTANTIATE_TEST_SUITE_P(At, CoarseCube, ::testing::ValuesIn(cubes()), nameOf);

class CoarseSlide : public ::testing::TestWithParam<double> {};

/// Slides down to a wall of the world and stays there: nothing is squashed against the wall and thrown back.
TEST_P(CoarseSlide, EndsAtTheWallOfTheWorld) {
  const double slope = 0.3;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(slope, Eigen::Vector3d::UnitY()).toRotationMatrix();
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Trial t = shakenCube(5, 0.005, GetParam(), 0.0, seed);
    for (InitialParticle& p : t.particles)
      p.position = (turn * p.position.cast<double>() + 0.9 * turn.col(0)).cast<float>();
    t.materials[0].friction = 0.2;
    t.solids = [slope](double) { return std::vector<Solid>{ground(slope)}; };
    t.frames = static_cast<int>(6.0 / GetParam());
    watch(t);
  }
}
INSTANTIATE_TEST_SUITE_P(Seconds, CoarseSlide, ::testing::Values(1.0 / 60.0, 0.033, 0.05, 0.1),
                         [](const ::testing::TestParamInfo<double>& tested) {
                           return std::to_string(std::lround(1e3 * tested.param)) + "ms";
                         });

}  // namespace
}  // namespace tactile_clay::clay::coarse_steps_test
