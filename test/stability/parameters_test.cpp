#include <random>
#include <sstream>

#include "watch.h"

/// The extremes of every parameter, one at a time, and all at once at random: a cube is dropped by a spacing.
namespace tactile_clay::clay {
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

/// A block that clings: set down, tumbling or thrown, on a table, a slope or a wedge, with coefficients of
/// friction from 1 to 10, in steps of any length.
Trial clinging(std::mt19937& random) {
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto between = [&](double low, double high) {  // log uniform
    return low * std::pow(high / low, uniform(0.0, 1.0));
  };
  const auto oneOf = [&random](int count) {
    return std::uniform_int_distribution<int>(0, count - 1)(random);
  };
  const auto turned = [&](double angle) {
    const Eigen::Vector3d axis(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0));
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  };
  Trial t;
  t.config.threads = 1;
  t.config.spacing = between(0.001, 0.05);
  const double d = t.config.spacing;
  t.config.budget = {1 + oneOf(4), 4 + 4 * oneOf(4)};
  t.config.frame = t.config.budget.substeps * between(1e-4, 0.1);
  t.config.gravity *= oneOf(3) == 0 ? between(0.1, 100.0) : 1.0;
  Material& m = t.materials[0];
  m.density = between(300.0, 5000.0);
  m.bulk_modulus = between(1e4, 1e8);
  m.viscosity = oneOf(4) == 0 ? 0.0 : between(1.0, 1e6);
  m.stiffness = oneOf(4) == 0 ? 0.0 : between(1e3, 1e7);
  m.yield_strain = between(0.001, 1.0);
  m.friction = between(1.0, 10.0);
  std::vector<Solid> solids{ground(oneOf(2) == 0 ? 0.0 : uniform(0.05, 1.2))};
  if (oneOf(3) == 0) solids.push_back(ground(-uniform(0.05, 1.2)));
  t.solids = [solids](double) { return solids; };
  const int pose = oneOf(3);  // standing, tilted, thrown
  const Eigen::Matrix3d turn = turned(pose == 0 ? 0.0 : pose == 1 ? 0.3 : uniform(0.0, M_PI));
  t.particles = block(2 + oneOf(5), 2 + oneOf(5), 1 + oneOf(6), d, Eigen::Vector3d::Zero(), turn);
  double lift = 0.0;
  for (const Solid& solid : solids) {
    const Eigen::Vector3d out = solid.pose.linear().col(2);
    for (const InitialParticle& p : t.particles)
      lift = std::max(lift, (0.5 * d - out.dot(p.position.cast<double>())) / out.z());
  }
  const Eigen::Vector3f velocity = turned(1.0).col(0).cast<float>() * static_cast<float>(between(0.05, 10.0));
  for (InitialParticle& p : t.particles) {
    p.position.z() += static_cast<float>(lift);
    if (pose == 2) p.velocity = velocity;
  }
  t.frames = 300 / t.config.budget.substeps;
  return t;
}

/// These blocks are thrown if friction counts as constant while the slip turns, or if its springs store more
/// energy than was put in.
void watchClinging(unsigned seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  watch(clinging(random));
}
class Clinging : public ::testing::TestWithParam<unsigned> {};
TEST_P(Clinging, GainsNoEnergy) {
  for (unsigned k = 0; k < 10; ++k) watchClinging(GetParam() + k);
}
INSTANTIATE_TEST_SUITE_P(Seeds, Clinging, ::testing::Range(1u, 201u, 10u),
                         ::testing::PrintToStringParamName());
/// In seeds 1957, 2310, 3139 and 3452, contacts that close pull clay onto them, harder than it moves by
/// itself.
INSTANTIATE_TEST_SUITE_P(PulledOn, Clinging, ::testing::Values(1951u, 2301u, 3131u, 3451u),
                         ::testing::PrintToStringParamName());

/// Seed 336 gained energy before lumps had steps of their own and compression was kept up to twice the
/// density.
INSTANTIATE_TEST_SUITE_P(Crumbs, Clinging, ::testing::Values(331u), ::testing::PrintToStringParamName());

/// Fails: of seeds 1 to 4000 these gain energy.
class ClingingTooFast : public ::testing::TestWithParam<unsigned> {};
TEST_P(ClingingTooFast, DISABLED_GainsNoEnergy) {
  watchClinging(GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seed, ClingingTooFast,
                         ::testing::Values(876u, 893u, 1916u, 2677u, 3101u, 3541u, 3705u),
                         ::testing::PrintToStringParamName());

/// The same without viscosity, bonds and friction. Clay slides together in the edge of two solids, or of the
/// world, where particles pass each other by more than a spacing in a step. If the compression that this
/// leaves counts as stored energy, it throws them.
void watchPile(unsigned seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  Trial t = clinging(random);
  t.materials[0].viscosity = t.materials[0].stiffness = t.materials[0].friction = 0.0;
  watch(t);
}
class Pile : public ::testing::TestWithParam<unsigned> {};
TEST_P(Pile, GainsNoEnergy) {
  for (unsigned k = 0; k < 10; ++k) watchPile(GetParam() + k);
}
/// Seeds that failed in earlier versions: 506 and 1395 were lifted when room was made by more than a spacing
/// per step, 1088 when expelled particles were not reported, 745 fell through a wedge, and in 811, 2048 and
/// 3217 the energy that is lent to compression added up.
INSTANTIATE_TEST_SUITE_P(Seeds, Pile, ::testing::Range(1u, 1501u, 10u), ::testing::PrintToStringParamName());
INSTANTIATE_TEST_SUITE_P(MoreSeeds, Pile, ::testing::Values(1871u, 2041u, 2461u, 3211u, 3671u),
                         ::testing::PrintToStringParamName());

/// The same, but started up to four spacings inside the table, the slope or the wedge. Particles inside are
/// pushed out along the normals at 0.1 m/s. They may gain as much energy as walls give that move at 0.5 m/s:
/// elastic clay leaves with twice the speed that has this component along all normals, and clay that walls
/// squeeze stores more. In a wedge the walls also slide on the clay, and each presses harder because of the
/// friction of the other. If that friction counted as load, there would be no limit, and clay would be thrown
/// at 100 m/s.
void watchInside(unsigned seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  Trial t = clinging(random);
  t.overlap = t.config.spacing * std::uniform_real_distribution<double>(0.1, 4.0)(random);
  for (InitialParticle& p : t.particles) p.position.z() -= static_cast<float>(t.overlap);
  Eigen::Vector3d normals = Eigen::Vector3d::Zero();
  const std::vector<Solid> solids = t.solids(0.0);
  for (const Solid& solid : solids)
    normals += solid.pose.linear().col(2) / static_cast<double>(solids.size());
  t.collider_speed = 0.5 / normals.norm();
  watch(t);
}
class Inside : public ::testing::TestWithParam<unsigned> {};
TEST_P(Inside, RecoversAtItsSpeed) {
  for (unsigned k = 0; k < 10; ++k) watchInside(GetParam() + k);
}
INSTANTIATE_TEST_SUITE_P(Seeds, Inside, ::testing::Range(301u, 531u, 10u),
                         ::testing::PrintToStringParamName());

/// Seeds that gained more energy than is allowed when they were pushed out at 0.5 m/s. Exceptions: 5023 did
/// so when particles that started in a solid and strayed deeper were pushed out at once; 618, if all lumps
/// have common steps of conjugate gradients; 6738, before lumps had steps of their own and compression was
/// kept up to twice the density; 1034 and 1233, if the work of walls that squeeze clay is stored in its
/// compression, too.
class InsideSeed : public ::testing::TestWithParam<unsigned> {};
TEST_P(InsideSeed, RecoversAtItsSpeed) {
  watchInside(GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seed, InsideSeed,
                         ::testing::Values(215u, 267u, 299u, 537u, 618u, 706u, 715u, 969u, 1034u, 1035u,
                                           1136u, 1218u, 1233u, 1240u, 1243u, 1544u, 1629u, 1891u, 5023u,
                                           6738u),
                         ::testing::PrintToStringParamName());

/// Fails: of seeds 1 to 8000 these gain more than is allowed.
class InsideTooFast : public ::testing::TestWithParam<unsigned> {};
TEST_P(InsideTooFast, DISABLED_RecoversAtItsSpeed) {
  watchInside(GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seed, InsideTooFast, ::testing::Values(1727u, 2310u, 4796u, 4934u),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace tactile_clay::clay
