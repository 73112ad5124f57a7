#include <random>
#include <sstream>

#include "watch.h"

/// The extremes of every parameter, one at a time, and all at once at random: a cube is dropped by a spacing.
namespace tactile_clay::clay::parameters_test {
namespace {

Trial drop(int edge = 5) {
  Trial t;
  t.config.threads = 2;
  t.particles = block(edge, edge, edge, t.config.spacing, {0.0, 0.0, t.config.spacing});
  return t;
}

std::string print(double value) {
  std::ostringstream text;
  text << value;
  std::string name = text.str();
  for (char& c : name) {
    if (c == '.') c = 'p';
    if (c == '-') c = 'm';
    if (c == '+') c = '_';
  }
  return name;
}
std::string nameOf(const ::testing::TestParamInfo<double>& tested) {
  return print(tested.param);
}

/// A cube dropped, standing, striking the ground, and on a slope on which it slides, in steps of a given
/// length.
std::vector<Trial> cubesAt(double step) {
  Trial falling = drop(), standing = drop(), striking = drop(), sliding = drop();
  standing.particles = block(5, 5, 5, standing.config.spacing);
  striking.particles = block(5, 5, 5, striking.config.spacing, {0.0, 0.0, 2e-5});  // met at 1 us a step too
  for (InitialParticle& p : striking.particles) p.velocity = {0.1f, 0.0f, -0.3f};
  const double slope = 0.3;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(slope, Eigen::Vector3d::UnitY()).toRotationMatrix();
  sliding.particles = block(5, 5, 5, sliding.config.spacing, Eigen::Vector3d::Zero(), turn);
  sliding.solids = [slope](double) { return std::vector<Solid>{ground(slope)}; };
  sliding.materials[0].friction = 0.2;
  std::vector<Trial> trials{falling, standing, sliding, striking};
  for (Trial& t : trials) {
    t.config.budget.substeps = 1;
    t.config.frame = step;
    t.frames = 240;
  }
  return trials;
}

class Step : public ::testing::TestWithParam<double> {};
TEST_P(Step, KeepsTheEnergy) {
  for (const Trial& t : cubesAt(GetParam())) watch(t);
}
INSTANTIATE_TEST_SUITE_P(Seconds, Step,
                         ::testing::Values(1e-6, 1e-5, 1e-4, 1e-3, 1.0 / 480, 1.0 / 240, 1.0 / 120), nameOf);

class CoarseStep : public ::testing::TestWithParam<double> {};
TEST_P(CoarseStep, KeepsTheEnergy) {
  for (const double viscosity : {190.0, 195.0, 200.0, 205.0, 210.0}) {
    for (Trial t : cubesAt(GetParam())) {
      t.materials[0].viscosity = viscosity;
      watch(t);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Seconds, CoarseStep, ::testing::Values(1.0 / 80, 1.0 / 60, 0.025, 0.033, 0.1),
                         nameOf);

void slideInStepsOf(double step) {
  Trial t = cubesAt(step)[2];
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix();
  t.particles = block(3, 3, 3, t.config.spacing, turn * Eigen::Vector3d(0.15, 0.1, 0.0), turn);
  Clay clay(t.config, t.materials, t.particles);
  for (int k = 0; k < 8000; ++k) clay.advance({}, t.solids(0.0), t.config.frame);
  const Eigen::Vector3d down = turn.col(0);
  const double expected = 9.81 * (std::sin(0.3) - 0.2 * std::cos(0.3)) * clay.time();
  EXPECT_NEAR(down.dot(momentum(clay.particles())) / totalMass(clay.particles()), expected, 0.05 * expected);
}
TEST(ShortStep, SlidesAsItShould) {
  slideInStepsOf(1e-4);
}

/// Fails: displacements of a step, and the stretch of the friction springs (mu g dt^2 / 20), are smaller than
/// the resolution of positions in single precision. Measured on a slope of 0.3 rad, mu = 0.2: in steps of
/// 0.1 ms the normal force is 1.8 % off; in steps of 10 us the cube has half of its speed. Carrying the
/// remainders of positions cures that, down to 10 us. But with it a cube that stands still starts to move in
/// steps of 25 ms; now rounding keeps it still.
class FineStep : public ::testing::TestWithParam<double> {};
TEST_P(FineStep, DISABLED_SlidesAsItShould) {
  slideInStepsOf(GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seconds, FineStep, ::testing::Values(1e-6, 1e-5), nameOf);

class Spacing : public ::testing::TestWithParam<double> {};
TEST_P(Spacing, OfParticles) {
  Trial t = drop();
  t.config.spacing = GetParam();
  t.particles = block(5, 5, 5, GetParam(), {0.0, 0.0, GetParam()});
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Metres, Spacing, ::testing::Values(0.001, 0.0025, 0.01, 0.05), nameOf);

class Viscosity : public ::testing::TestWithParam<double> {};
TEST_P(Viscosity, WithBonds) {
  Trial t = drop();
  t.materials[0].viscosity = GetParam();
  watch(t);
}
TEST_P(Viscosity, WithoutBonds) {
  Trial t = drop();
  t.materials[0].viscosity = GetParam();
  t.materials[0].stiffness = 0.0;
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(PascalSeconds, Viscosity, ::testing::Values(0.0, 0.1, 10.0, 1e4, 1e6), nameOf);

class Stiffness : public ::testing::TestWithParam<double> {};
TEST_P(Stiffness, WithViscosity) {
  Trial t = drop();
  t.materials[0].stiffness = GetParam();
  watch(t);
}
TEST_P(Stiffness, WithoutViscosity) {
  Trial t = drop();
  t.materials[0].stiffness = GetParam();
  t.materials[0].viscosity = 0.0;
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Pascals, Stiffness, ::testing::Values(0.0, 1e3, 1e4, 1e6, 1e7, 1e9), nameOf);

class Bulk : public ::testing::TestWithParam<double> {};
TEST_P(Bulk, Modulus) {
  Trial t = drop();
  t.materials[0].bulk_modulus = GetParam();
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Pascals, Bulk, ::testing::Values(0.0, 1e3, 1e8, 1e10), nameOf);

class Yield : public ::testing::TestWithParam<double> {};
TEST_P(Yield, Strain) {
  Trial t = drop();
  t.materials[0].yield_strain = GetParam();
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Of, Yield, ::testing::Values(1e-9, 1e-4, 0.5, 1.0, 10.0), nameOf);

class Rates : public ::testing::TestWithParam<double> {};
TEST_P(Rates, OfBonding) {
  Trial t = drop();
  t.materials[0].bond_rate = t.materials[0].unbond_rate = GetParam();
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(PerSecond, Rates, ::testing::Values(0.0, 1e-6, 0.1, 1e6), nameOf);

class Friction : public ::testing::TestWithParam<double> {};
TEST_P(Friction, OnASlope) {
  const double slope = 0.4;
  Trial t = drop();
  t.materials[0].friction = GetParam();
  t.solids = [slope](double) { return std::vector<Solid>{ground(slope)}; };
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(slope, Eigen::Vector3d::UnitY()).toRotationMatrix();
  t.particles = block(5, 5, 5, t.config.spacing, turn * Eigen::Vector3d(0.0, 0.0, t.config.spacing), turn);
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Coefficient, Friction, ::testing::Values(0.0, 0.01, 1.0, 10.0), nameOf);

class Adhesion : public ::testing::TestWithParam<double> {};
TEST_P(Adhesion, UnderACeiling) {
  Trial t = drop();
  t.materials[0].adhesion = GetParam();
  t.solids = [](double) {
    std::vector<Solid> solids{ground(), ground()};
    solids[1].pose = Eigen::Translation3d(0.0, 0.0, 0.13);
    return solids;
  };
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Pascals, Adhesion, ::testing::Values(1.0, 3e3, 1e7), nameOf);

class Gravity : public ::testing::TestWithParam<double> {};
TEST_P(Gravity, Times) {
  Trial t = drop();
  t.config.gravity *= GetParam();
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Earths, Gravity, ::testing::Values(0.0, 0.1, 1.0, 10.0, 100.0), nameOf);

class DensityRatio : public ::testing::TestWithParam<double> {};
TEST_P(DensityRatio, OfTheUpperCubeToTheLower) {
  Trial t = drop(4);
  t.materials.assign(2, Material());
  t.materials[0].density = 1000.0 / std::sqrt(GetParam());
  t.materials[1].density = 1000.0 * std::sqrt(GetParam());
  const auto upper = block(4, 4, 4, t.config.spacing, {0.001, 0.0, 0.0275}, Eigen::Matrix3d::Identity(), 1);
  t.particles.insert(t.particles.end(), upper.begin(), upper.end());
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(Times, DensityRatio, ::testing::Values(1e-3, 1.0, 1e3), nameOf);

void watchRandom(unsigned seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto between = [&random](double low, double high) {  // log uniform
    return low * std::pow(high / low, std::uniform_real_distribution<double>()(random));
  };
  const auto sometimes = [&random](double otherwise, double value) {
    return std::uniform_int_distribution<int>(0, 3)(random) == 0 ? otherwise : value;
  };
  Trial t;
  t.config.threads = 2;
  t.config.spacing = between(0.002, 0.02);
  t.config.frame = between(1e-4, 1.0 / 60.0);
  t.config.budget = {std::uniform_int_distribution<int>(2, 8)(random),
                     std::uniform_int_distribution<int>(4, 24)(random)};
  Material& m = t.materials[0];
  m.density = between(300.0, 5000.0);
  m.bulk_modulus = between(1e4, 1e7);
  m.viscosity = sometimes(0.0, between(1.0, 1e5));
  m.stiffness = sometimes(0.0, between(1e3, 1e6));
  m.bond_rate = between(0.01, 10.0);
  m.unbond_rate = m.bond_rate * between(1.0, 100.0);
  m.yield_strain = between(0.001, 1.0);
  m.friction = sometimes(0.0, between(0.01, 10.0));
  m.skin_friction = sometimes(0.0, between(0.01, 10.0));
  const Eigen::Matrix3d turn = Eigen::Quaterniond(Eigen::Vector4d(between(0.1, 1.0), between(0.1, 1.0),
                                                                  between(0.1, 1.0), between(0.1, 1.0))
                                                      .normalized())
                                   .toRotationMatrix();
  const double d = t.config.spacing;
  t.particles = block(5, 4, 5, d, {0.0, 0.0, 7.0 * d}, turn);
  const double speed = between(0.01, 2.0);
  t.collider_speed = speed;
  t.squeezes = true;
  t.samples = [d, speed](double time) {
    const double z = std::max(20.0 * d - speed * time, 4.0 * d);
    return sampleBall({0.0, 0.0, z}, 3.0 * d, 0.8 * d, {0.0, 0.0, z > 4.0 * d ? -speed : 0.0});
  };
  watch(t);
}
class Random : public ::testing::TestWithParam<unsigned> {};
TEST_P(Random, Parameters) {
  watchRandom(GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seed, Random, ::testing::Range(1u, 61u), ::testing::PrintToStringParamName());
/// Nearly inviscid clay without bonds: the set of compressed particles changes with every step.
INSTANTIATE_TEST_SUITE_P(InviscidPiles, Random, ::testing::Values(96u, 237u),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace tactile_clay::clay::parameters_test
