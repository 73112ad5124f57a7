#include "clay/clay.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "support/setups.h"

namespace tactile_clay::clay {
namespace {

constexpr double spacing = 0.005;

ClayConfig configOf(int substeps = 4, int iterations = 8) {
  ClayConfig config;
  config.spacing = spacing;
  config.budget = {substeps, iterations};
  config.threads = 1;
  config.sleeping = false;  // what is asleep cannot fail
  return config;
}

void run(Clay& clay, int frames, const Skin& samples = {}, const std::vector<Solid>& solids = {}) {
  for (int k = 0; k < frames; ++k) clay.advance(samples, solids, clay.config().frame);
}

bool sameBits(const VectorField& a, const VectorField& b) {
  return a.size() == b.size() && std::memcmp(&a[0], &b[0], a.size() * sizeof(a[0])) == 0;
}

TEST(Clay, FallsFreely) {
  Clay clay(configOf(), {Material()}, block(5, 5, 5, spacing));
  const double start = centreOfMass(clay.particles()).z();
  run(clay, 12);
  // 48 steps of implicit Euler: v = -g t, x = -g (t^2 + t dt) / 2
  const double t = clay.time(), dt = 1.0 / 240.0;
  EXPECT_NEAR(t, 0.2, 1e-12);
  EXPECT_NEAR(centreOfMass(clay.particles()).z() - start, -0.5 * 9.81 * t * (t + dt), 1e-6);
  EXPECT_NEAR(momentum(clay.particles()).z(), -9.81 * t * totalMass(clay.particles()),
              1e-5 * 9.81 * t * totalMass(clay.particles()));
  EXPECT_LT(internalSpeed(clay.particles()), 1e-4);
}

TEST(Clay, ConservesMomentum) {
  auto particles = block(6, 6, 6, spacing);
  std::mt19937 random(1);
  std::normal_distribution<float> speed(0.0f, 0.1f);
  double size = 0.0;
  for (InitialParticle& p : particles) {
    for (int a = 0; a < 3; ++a) p.velocity[a] = speed(random);
  }
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {Material()}, particles);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    size += mass(clay.particles(), i) * clay.particles().velocity.at(i).norm();
  }
  const Eigen::Vector3d before = momentum(clay.particles());
  run(clay, 30);
  EXPECT_LT((momentum(clay.particles()) - before).norm(), 1e-5 * size);
}

/// Internal forces act along pairs, and so turn nothing.
TEST(Clay, KeepsSpinning) {
  auto particles = block(6, 6, 6, spacing);
  const Eigen::Vector3f spin(0.0f, 2.0f, 6.0f), centre(0.0f, 0.0f, static_cast<float>(3.0 * spacing));
  for (InitialParticle& p : particles) p.velocity = spin.cross(p.position - centre);
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {Material()}, particles);
  const Eigen::Vector3d before = angularMomentum(clay.particles());
  run(clay, 60);
  EXPECT_LT((angularMomentum(clay.particles()) - before).norm(), 1e-4 * before.norm());
}

/// Compression that no work was done for makes room, but no motion.
TEST(Clay, CompressionThatIsNotPaidForIsUndoneAtRest) {
  Material material;
  material.viscosity = material.stiffness = 0.0;
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {material}, block(6, 6, 6, 0.93 * spacing));
  Sculpture squeezed = clay.sculpture();
  std::fill(squeezed.compression.begin(), squeezed.compression.end(), 0.0f);
  clay.restore(squeezed);
  clay.advance({}, {}, config.frame / 4);
  const double before = clay.statistics().density_error_mean;  // as the step began
  run(clay, 2);
  EXPECT_LT(clay.statistics().density_error_mean, 0.1 * before);
  EXPECT_LT(meanSpeed(clay.particles()), 0.05);
}

/// Iterations stop when no particle lacks more acceleration than the tolerance. A block that settles needs
/// few iterations, a block at rest none, and the iterations that are left out move nothing.
TEST(Clay, IterationsStopUnderTheTolerance) {
  struct Settled {
    double iterations = 0.0, at_rest = 0.0;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  };
  const auto settle = [](double tolerance) {
    ClayConfig config = configOf();
    config.tolerance = tolerance;
    config.sleeping = false;
    Clay clay(config, {Material()}, block(6, 6, 6, spacing));
    Settled settled;
    for (int k = 0; k < 60; ++k) {
      clay.advance({}, {ground()}, config.frame);
      settled.iterations += clay.statistics().iterations;
    }
    settled.at_rest = clay.statistics().iterations;
    settled.centre = centreOfMass(clay.particles());
    const double top = 6.0 * spacing - 0.25 * spacing;
    const Skin palm = samplePlane({0.0, 0.0, top}, -Eigen::Vector3d::UnitZ(), 0.02, 0.003, {0.0, 0.0, -0.1});
    clay.advance(palm, {ground()}, config.frame);
    EXPECT_GE(clay.statistics().iterations, 0.75 * config.budget.iterations);
    return settled;
  };
  const Settled exact = settle(0.0), enough = settle(0.05);
  EXPECT_EQ(enough.at_rest, 0.0);
  EXPECT_LT(enough.iterations, 0.8 * exact.iterations);
  EXPECT_LT((enough.centre - exact.centre).norm(), 1e-3 * spacing);
}

/// A step starts from the whole turn of a lump, not from its tangent, so that a lump neither grows with each
/// step nor needs iterations to be pulled back. It grows by its centrifugal strain, of the order of rho
/// omega^2 R^2 / E.
TEST(Clay, ASpinningBlockKeepsItsSizeAtAnyBudget) {
  constexpr double omega = 12.0;  // rad/s
  const double radius = 3.0 * spacing;
  const auto size = [](const Particles& p) {  // about the axis
    double sum = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += p.position.at(i).head<2>().squaredNorm();
    return std::sqrt(sum / static_cast<double>(p.size()));
  };
  for (const int iterations : {1, 2, 4, 8}) {
    auto particles = block(6, 6, 6, spacing);
    for (InitialParticle& p : particles) p.velocity = Eigen::Vector3f(0, 0, omega).cross(p.position);
    ClayConfig config = configOf();
    config.gravity.setZero();
    config.budget = {4, iterations};
    const Material material;
    Clay clay(config, {material}, particles);
    const double before = size(clay.particles());
    run(clay, 120);
    const double strain = material.density * std::pow(omega * radius, 2.0) / material.stiffness;
    EXPECT_NEAR(size(clay.particles()) / before, 1.0, 0.5 * strain) << iterations << " iterations";
  }
}

TEST(Clay, KeepsSpinningWithoutViscosity) {
  auto particles = block(6, 6, 6, spacing);
  const Eigen::Vector3f spin(0.0f, 2.0f, 6.0f), centre(0.0f, 0.0f, static_cast<float>(3.0 * spacing));
  for (InitialParticle& p : particles) p.velocity = spin.cross(p.position - centre);
  ClayConfig config = configOf();
  config.gravity.setZero();
  Material elastic;
  elastic.viscosity = 0.0;
  Clay clay(config, {elastic}, particles);
  const Eigen::Vector3d before = angularMomentum(clay.particles());
  run(clay, 60);
  EXPECT_LT((angularMomentum(clay.particles()) - before).norm(), 1e-4 * before.norm());
}

/// Bonds left of a pair that is set going at `rate` (1/s, of its length) and watched for two frames.
std::size_t bondsOfPair(double rate, double stiffness, int substeps) {
  Material material;
  material.viscosity = material.bulk_modulus = 0.0;
  material.stiffness = stiffness;
  material.bond_rate = 1.0;
  material.unbond_rate = 10.0;
  material.yield_strain = 2.0;
  ClayConfig config = configOf(substeps, 8);
  config.gravity.setZero();
  const float half = static_cast<float>(0.5 * rate * spacing);
  Clay clay(config, {material},
            {{{0, 0, 0}, {-half, 0, 0}, 0, 0}, {{static_cast<float>(spacing), 0, 0}, {half, 0, 0}, 0, 0}});
  run(clay, 2);
  return clay.statistics().bonds;
}

/// Lumps do not interact: a force on one lump moves no other, however few iterations there are. With one
/// common step along a direction for all lumps, a crumb was moved as the block was.
TEST(Clay, ACrumbSlidesAsIfNoBlockWereCrushed) {
  const auto wayOfCrumb = [](bool beside) {
    std::vector<InitialParticle> particles;
    if (beside) particles = block(6, 6, 6, spacing);
    InitialParticle crumb;
    crumb.position = {0.0f, 0.2f, static_cast<float>(0.5 * spacing)};
    crumb.velocity = {2.0f, 0.0f, 0.0f};
    particles.push_back(crumb);
    Clay clay(configOf(4, 6), {Material()}, particles);
    for (int k = 0; k < 12; ++k) {
      const double down = 2.0, height = 0.08 - down * clay.config().frame * k;
      const Eigen::Vector3d at(0.0, 0.0, std::max(height, 0.5 * spacing));
      clay.advance(samplePlane(at, -Eigen::Vector3d::UnitZ(), 0.03, 0.004, {0.0, 0.0, -down}), {ground()},
                   clay.config().frame);
    }
    return clay.particles().position.at(particles.size() - 1).x();
  };
  const double alone = wayOfCrumb(false);
  EXPECT_GT(alone, 0.1);
  EXPECT_NEAR(wayOfCrumb(true), alone, 1e-3 * alone);
}

TEST(Clay, BondsPartByWhatAFrameDoesHoweverItIsCut) {
  for (const int substeps : {1, 4, 16, 64}) {
    EXPECT_EQ(bondsOfPair(9.0, 1e-3, substeps), 1u) << substeps;
    EXPECT_EQ(bondsOfPair(13.0, 1e-3, substeps), 0u) << substeps;
    // One that vibrates by 5 % of its length, at velocities of twice the rate.
    EXPECT_EQ(bondsOfPair(20.0, 3200.0, substeps), 1u) << substeps;
  }
}

class AtBudget : public ::testing::TestWithParam<std::pair<int, int>> {};

void expectDeadRest(int edge, int substeps, int iterations) {
  Clay clay(configOf(substeps, iterations), {Material()}, block(edge, edge, edge, spacing));
  const double weight = 9.81 * totalMass(clay.particles());
  run(clay, 40, {}, {ground()});
  EXPECT_NEAR(-clay.solidForces()[0].z(), weight, 1e-3 * weight) << edge << " particles high";
  EXPECT_LT(clay.solidForces()[0].head<2>().norm(), 1e-3 * weight);
  EXPECT_LT(meanSpeed(clay.particles()), 1e-5) << edge << " particles high";
  EXPECT_GT(extent(clay.particles(), Eigen::Vector3d::UnitZ()).second, 0.98 * (edge - 0.5) * spacing);
}

TEST_P(AtBudget, ARestingBlockPressesWithItsWeightAndIsDeadStill) {
  expectDeadRest(5, GetParam().first, GetParam().second);
}

/// At the presets `fast` and `balanced`.
TEST(Clay, AnyCubeComesToRest) {
  for (const int edge : {4, 5, 6, 7, 8, 9, 10, 12}) {
    expectDeadRest(edge, 4, 6);
    expectDeadRest(edge, 4, 8);
  }
}

TEST(Clay, FourIterationsBringAnyCubeToRest) {
  for (const int edge : {4, 5, 6, 7, 8, 10}) expectDeadRest(edge, 4, 4);
}

/// A thumb has left a dent and a rim that stands off the ground. The block comes to rest, however stiff it is
/// and however few the iterations: a step gains no energy (without the first direction of `descend` it buzzes
/// at 30 mm/s).
TEST(Clay, ADentedBlockComesToRest) {
  for (const double viscosity : {0.0, 50.0, 200.0, 1000.0, 1e4}) {
    for (const int iterations : {4, 6, 8}) {
      Material material;
      material.viscosity = viscosity;
      Clay clay(configOf(4, iterations), {material}, block(5, 5, 5, spacing));
      for (int k = 1; k <= 48; ++k) {
        const double depth = 0.02 * std::sin(k * M_PI / 48.0),
                     before = 0.02 * std::sin((k - 1) * M_PI / 48.0);
        const Eigen::Vector3d velocity(0.0, 0.0, -60.0 * (depth - before));
        clay.advance(
            samplePlane({0.0, 0.0, 0.037 - depth}, -Eigen::Vector3d::UnitZ(), 0.006, 0.003, velocity),
            {ground()}, 1.0 / 60.0);
      }
      run(clay, 180, {}, {ground()});
      EXPECT_LT(meanSpeed(clay.particles()), 1e-5) << viscosity << " Pa s, " << iterations << " iterations";
    }
  }
}

TEST_P(AtBudget, ASkinCarriesARestingBlock) {
  Clay clay(configOf(GetParam().first, GetParam().second), {Material()}, block(5, 5, 5, spacing));
  const Skin palm = samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.03, 0.004);
  const double weight = 9.81 * totalMass(clay.particles());
  run(clay, 40, palm);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const SkinForce& f : clay.skinForces()) force += f.force.cast<double>();
  EXPECT_NEAR(-force.z(), weight, 1e-3 * weight);
  EXPECT_LT(force.head<2>().norm(), 1e-3 * weight);
  EXPECT_LT(meanSpeed(clay.particles()), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Budgets, AtBudget,
                         ::testing::Values(std::pair{4, 4}, std::pair{4, 8}, std::pair{8, 16}));

Eigen::Vector3d sumOf(const std::vector<SkinForce>& forces) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const SkinForce& f : forces) sum += f.force.cast<double>();
  return sum;
}

/// Newton's third law through the clay: the table feels the force of the palm plus the weight, and the
/// difference is the rate of momentum.
TEST(Clay, ForcesOnPalmAndTableAreTheRateOfMomentum) {
  Material soft;
  soft.yield_strain = 0.05;
  Clay clay(configOf(), {soft}, block(6, 6, 6, spacing));
  const double weight = 9.81 * totalMass(clay.particles()), speed = 0.02;
  double strongest = 0.0;
  for (int k = 1; k <= 20; ++k) {
    const double before = momentum(clay.particles()).z(), z = 0.03 - speed * clay.config().frame * k;
    clay.advance(samplePlane({0.0, 0.0, z}, -Eigen::Vector3d::UnitZ(), 0.024, 0.004, {0.0, 0.0, -speed}),
                 {ground()}, clay.config().frame);
    std::int64_t last = -1;
    for (const SkinForce& f : clay.skinForces()) {
      ASSERT_LT(last, f.index) << "not by ascending sample";
      last = f.index;
    }
    const double palm = sumOf(clay.skinForces()).z(), table = clay.solidForces()[0].z();
    const double change = (momentum(clay.particles()).z() - before) / clay.config().frame;
    if (k > 2) {
      EXPECT_NEAR(palm + table + change, -weight, 0.01 * palm) << "frame " << k;  // all on the surroundings
    }
    strongest = std::max(strongest, palm);
  }
  EXPECT_GT(strongest, 5.0);
}

/// Few iterations leave much of an impact unsolved; the impulse on the skin is the momentum of the block all
/// the same.
TEST(Clay, AnImpactOnTheSkinIsTheRateOfMomentum) {
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {Material()}, block(5, 5, 5, spacing));
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  for (int k = 1; k <= 12; ++k) {
    const Eigen::Vector3d velocity(0.02, 0.0, 0.1), start(0.0, 0.0, -0.014);
    clay.advance(sampleBall(start + k * config.frame * velocity, 0.015, 0.004, velocity), {}, config.frame);
    impulse += config.frame * sumOf(clay.skinForces());
  }
  EXPECT_LT((impulse + momentum(clay.particles())).norm(), 1e-3 * momentum(clay.particles()).norm());
}

/// Without friction a block keeps its place over skin that is drawn away below it: the slip is the speed of
/// the skin. With a little, mu, it is drawn along at mu g (Coulomb); with much of it nothing slides.
TEST(Clay, SlipIsTheSpeedAtWhichClaySlidesAlongTheSkin) {
  const double speed = 0.05;  // m/s
  for (const double friction : {0.0, 0.01, 5.0}) {
    Material material;
    material.skin_friction = friction;
    Clay clay(configOf(), {material}, block(5, 5, 5, spacing));
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    run(clay, 40, samplePlane(centre, Eigen::Vector3d::UnitZ(), 0.04, 0.004));
    for (const SkinForce& f : clay.skinForces()) EXPECT_LT(f.slip, 1e-3) << "at rest";
    for (int k = 0; k < 15; ++k) {
      centre.x() += speed * clay.config().frame;
      clay.advance(samplePlane(centre, Eigen::Vector3d::UnitZ(), 0.04, 0.004, {speed, 0.0, 0.0}), {},
                   clay.config().frame);
    }
    ASSERT_FALSE(clay.skinForces().empty());
    double force = 0.0, slip = 0.0;
    for (const SkinForce& f : clay.skinForces()) {
      force += f.force.norm();
      slip += f.force.norm() * f.slip;
    }
    const double middle = 14.5 * clay.config().frame;  // s, of the last frame
    EXPECT_NEAR(slip / force, std::max(speed - friction * 9.81 * middle, 0.0), 0.05 * speed)
        << "friction " << friction;
  }
}

TEST(Clay, GivesTheSameBitsForAnyNumberOfThreads) {
  std::vector<VectorField> positions;
  for (const int threads : {1, 2, 3, 1}) {
    ClayConfig config = configOf();
    config.threads = threads;
    auto particles = block(8, 8, 5, spacing);
    const auto lump = block(4, 4, 3, spacing, {0.004, 0.003, 0.035},
                            Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix());
    particles.insert(particles.end(), lump.begin(), lump.end());
    Material soft;
    soft.stiffness = 2e4;
    soft.yield_strain = 0.05;
    Clay clay(config, {soft}, particles);
    for (int k = 0; k < 60; ++k) {
      const Eigen::Vector3d velocity(0.0, 0.0, k < 30 ? -0.1 : 0.1);
      const double z = 0.073 - 0.1 * config.frame * (k < 30 ? k + 1 : 59 - k);
      clay.advance(sampleBall({0.0, 0.0, z}, 0.015, 0.005, velocity), {ground()}, config.frame);
    }
    positions.push_back(clay.particles().position);
  }
  for (std::size_t k = 1; k < positions.size(); ++k) EXPECT_TRUE(sameBits(positions[0], positions[k])) << k;
}

TEST(Clay, NamesTheParameterAndItsValue) {
  const auto messageOf = [](const ClayConfig& config, const std::vector<Material>& materials,
                            const std::vector<InitialParticle>& particles) -> std::string {
    try {
      const Clay clay(config, materials, particles);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  const auto expectNamed = [](const std::string& message, const std::string& name, const std::string& value) {
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_NE(message.find(value), std::string::npos) << message;
    EXPECT_NE(message.find("expected"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  };
  const auto config = [&](const std::string& name, const std::string& value, const auto& set) {
    ClayConfig c = configOf();
    set(c);
    expectNamed(messageOf(c, {Material()}, {}), name, value);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  config("spacing", "-0.5", [](ClayConfig& c) { c.spacing = -0.5; });
  config("spacing", "nan", [&](ClayConfig& c) { c.spacing = nan; });
  config("frame", "2.0", [](ClayConfig& c) { c.frame = 2.0; });
  config("substeps", "0", [](ClayConfig& c) { c.budget.substeps = 0; });
  config("iterations", "-1", [](ClayConfig& c) { c.budget.iterations = -1; });
  config("gravity", "nan", [&](ClayConfig& c) { c.gravity.y() = nan; });
  config("world", "0", [](ClayConfig& c) { c.world = 0.0; });
  config("threads", "-2", [](ClayConfig& c) { c.threads = -2; });
  const auto material = [&](const std::string& name, const std::string& value, const auto& set) {
    Material m;
    m.name = "putty";
    set(m);
    const std::string message = messageOf(configOf(), {m}, {});
    expectNamed(message, name, value);
    expectNamed(message, "putty", value);
  };
  material("density", "0", [](Material& m) { m.density = 0.0; });
  material("bulk_modulus", "-1", [](Material& m) { m.bulk_modulus = -1.0; });
  material("viscosity", "-3", [](Material& m) { m.viscosity = -3.0; });
  material("viscosity", "nan", [&](Material& m) { m.viscosity = nan; });
  material("stiffness", "-7", [](Material& m) { m.stiffness = -7.0; });
  material("bond_rate", "-1", [](Material& m) { m.bond_rate = -1.0; });
  material("unbond_rate", "0.5", [](Material& m) { m.unbond_rate = 0.5; });
  material("yield_strain", "0", [](Material& m) { m.yield_strain = 0.0; });
  material("friction", "-0.1", [](Material& m) { m.friction = -0.1; });
  material("skin_friction", "-0.2", [](Material& m) { m.skin_friction = -0.2; });
  material("adhesion", "-5", [](Material& m) { m.adhesion = -5.0; });
  expectNamed(messageOf(configOf(), {}, {}), "material", "at least one");
  auto particles = block(1, 1, 2, spacing);
  particles[1].position.x() = std::numeric_limits<float>::infinity();
  EXPECT_NE(messageOf(configOf(), {Material()}, particles).find("particle 1"), std::string::npos);
  particles = block(1, 1, 2, spacing);
  particles[1].material = 3;
  EXPECT_NE(messageOf(configOf(), {Material()}, particles).find("material 3"), std::string::npos);
}

TEST(Clay, BadSamplesDoNothing) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  Skin bad = samplePlane({0.0, 0.0, 0.01}, Eigen::Vector3d::UnitZ(), 0.02, 0.005);
  for (std::size_t g = 0; g < bad.size(); ++g) {
    const int axis = static_cast<int>(g % 3);
    if (g % 6 == 0) bad.position[g][axis] = nan;
    if (g % 6 == 1) bad.normal[g][axis] = nan;
    if (g % 6 == 2) bad.position[g][axis] = -inf;
    if (g % 6 == 3) bad.position[g].setConstant(1e30f);
    if (g % 6 == 4) bad.normal[g].setZero();
    if (g % 6 == 5) bad.normal[g][axis] = std::numeric_limits<float>::max();
    bad.velocity[g][axis] = nan;
  }
  Clay touched(configOf(), {Material()}, block(5, 5, 5, spacing));
  Clay left(configOf(), {Material()}, block(5, 5, 5, spacing));
  run(touched, 10, bad, {ground()});
  run(left, 10, {}, {ground()});
  EXPECT_TRUE(sameBits(touched.particles().position, left.particles().position));
  EXPECT_TRUE(touched.skinForces().empty());
}

TEST(Clay, ASampleWithoutAFiniteVelocityHasNone) {
  Skin hand = sampleBall({0.0, 0.0, 0.035}, 0.015, 0.004);
  Clay good(configOf(), {Material()}, block(5, 5, 5, spacing));
  run(good, 10, hand, {ground()});
  for (std::size_t g = 0; g < hand.size(); ++g) {
    hand.velocity[g][static_cast<int>(g % 3)] = std::numeric_limits<float>::quiet_NaN();
  }
  Clay bad(configOf(), {Material()}, block(5, 5, 5, spacing));
  run(bad, 10, hand, {ground()});
  EXPECT_FALSE(bad.skinForces().empty());
  EXPECT_TRUE(sameBits(good.particles().position, bad.particles().position));
}

TEST(Clay, CountsStepsOfFractionalDurations) {
  const double dt = 1.0 / 240.0;
  Clay whole(configOf(), {Material()}, block(3, 3, 3, spacing)),
      pieces(configOf(), {Material()}, block(3, 3, 3, spacing));
  for (int k = 0; k < 70; ++k) pieces.advance({}, {}, dt * 0.3);  // 21 steps
  EXPECT_NEAR(pieces.time(), 21.0 * dt, 1e-12);
  for (int k = 0; k < 21; ++k) whole.advance({}, {}, dt);
  EXPECT_TRUE(sameBits(whole.particles().position, pieces.particles().position));
  pieces.advance({}, {}, 0.4 * dt);
  EXPECT_NEAR(pieces.time(), 21.0 * dt, 1e-12);
  pieces.advance({}, {}, 0.2 * dt);
  EXPECT_NEAR(pieces.time(), 22.0 * dt, 1e-12);
  pieces.advance({}, {}, 0.0);
  EXPECT_NEAR(pieces.time(), 22.0 * dt, 1e-12);
  EXPECT_EQ(pieces.statistics().step, 73u);
}

TEST(Clay, ReportsItsStagesAndCounts) {
  Clay clay(configOf(), {Material()}, block(5, 5, 5, spacing));
  run(clay, 3, {}, {ground()});
  const Statistics& s = clay.statistics();
  EXPECT_EQ(s.step, 3u);
  EXPECT_EQ(s.contacts, 25u);
  EXPECT_GT(s.bonds, 300u);
  EXPECT_LT(s.density_error_max, 0.05);
  EXPECT_LE(s.density_error_mean, s.density_error_max);
  ASSERT_FALSE(s.stages.empty());
  for (const Stage& stage : s.stages) EXPECT_GE(stage.ms, 0.0) << stage.name;
}

TEST(Clay, NothingIsNothing) {
  Clay clay(configOf(), {Material()}, {});
  run(clay, 3, sampleBall(Eigen::Vector3d::Zero(), 0.01, 0.005), {ground()});
  EXPECT_EQ(clay.particles().size(), 0u);
  EXPECT_TRUE(clay.skinForces().empty());
  EXPECT_EQ(clay.solidForces().at(0).norm(), 0.0);
}

}  // namespace
}  // namespace tactile_clay::clay
