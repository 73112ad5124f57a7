#include <random>

#include "watch.h"

/// None of these gains energy: blocks that cling to tables, slopes and wedges, piles without friction, and
/// blocks that start inside solids.
namespace tactile_clay::clay::clinging_test {
namespace {

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
constexpr unsigned energetic_seeds[] = {215,  267,  299,  537,  618,  706,  715,  969,  1034, 1035,
                                        1136, 1218, 1233, 1240, 1243, 1544, 1629, 1891, 5023, 6738};
INSTANTIATE_TEST_SUITE_P(Seed, InsideSeed, ::testing::ValuesIn(energetic_seeds),
                         ::testing::PrintToStringParamName());

/// Fails: of seeds 1 to 8000 these gain more than is allowed.
class InsideTooFast : public ::testing::TestWithParam<unsigned> {};
TEST_P(InsideTooFast, DISABLED_RecoversAtItsSpeed) {
  watchInside(GetParam());
}
INSTANTIATE_TEST_SUITE_P(Seed, InsideTooFast, ::testing::Values(1727u, 2310u, 4796u, 4934u),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace tactile_clay::clay::clinging_test
