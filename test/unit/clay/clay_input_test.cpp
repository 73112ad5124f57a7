#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "clay/clay.h"
#include "clay_frames.h"
#include "support/setups.h"

/// What clay takes and tells: any number of threads, bad parameters, bad samples, any duration, its counts.
namespace tactile_clay::clay::clay_input_test {
namespace {

using namespace clay_frames;

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
}  // namespace tactile_clay::clay::clay_input_test
