#include <gtest/gtest.h>

#include "support/samples.h"

/// A dent stays: a flat disc goes into a block at 40 mm/s, is held for half a second and lifted. Measured
/// figures are in doc/method/validation.md.
namespace tactile_clay::clay::dent_test {
namespace {

constexpr double radius = 0.008, speed = 0.04;  // m, m/s
constexpr double area = M_PI * radius * radius;

struct Dent {
  double deep = 0.0;      // m, under the disc
  double left = 0.0;      // m, of it, a second after the disc was lifted
  double pressure = 0.0;  // Pa, mean, half a second after the disc came to rest
};

/// @param depth m, below the surface of the block
/// @param lifted false: ends with the disc in the clay
Dent dent(const Resolution& resolution, const Material& material, double depth, bool lifted = true,
          double block_width = 0.06, double block_height = 0.04) {
  constexpr double clearance = 0.001;  // m, of the disc at first
  ClayConfig config;
  config.spacing = resolution.spacing;
  config.budget = resolution.budget;
  config.sleeping = false;
  config.threads = 1;
  const int columns = static_cast<int>(std::lround(block_width / config.spacing));
  const int layers = static_cast<int>(std::lround(block_height / config.spacing));
  Clay clay(config, {material}, block(columns, columns, layers, config.spacing));
  Solid disc;
  disc.shape = Solid::Shape::cylinder;
  disc.size = {radius, 0.02, 0.0};
  disc.pose.translation().z() = layers * config.spacing + clearance + disc.size.y();
  const auto run = [&](double velocity, double duration) {
    const int frames = std::max(1, static_cast<int>(std::lround(duration / config.frame)));
    disc.linear_velocity.z() = velocity * duration / (frames * config.frame);
    for (int k = 0; k < frames; ++k) {
      clay.advance({}, {ground(), disc}, config.frame);
      disc.pose = poseAfter(disc, config.frame);
    }
  };
  // Mean height of the part of the top layer under the disc that its rim does not influence.
  const auto height = [&] {
    const Particles& p = clay.particles();
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = p.size() - static_cast<std::size_t>(columns * columns); i < p.size(); ++i) {
      if (p.position.at(i).head<2>().norm() > 0.7 * radius) continue;
      sum += static_cast<double>(p.position.at(i).z());
      ++count;
    }
    return sum / count;
  };
  Dent result;
  run(0.0, 0.2);
  const double before = height();
  run(-speed, (depth + clearance) / speed);
  result.deep = before - height();
  run(0.0, 0.5);
  result.pressure = clay.solidForces()[1].z() / area;
  if (!lifted) return result;
  run(0.06, (depth + 0.01) / 0.06);
  run(0.0, 1.0);
  result.left = before - height();
  return result;
}

/// Firm clay, E / tau_y = 150.
Material firm() {
  Material m;
  m.name = "firm clay";
  m.stiffness = 1e6;
  m.yield_strain = 0.01;
  m.bulk_modulus = 1e7;
  return m;
}

class Dents : public ::testing::TestWithParam<Resolution> {};

/// The elastic recovery of a half space under a rigid flat punch, P (1 - nu^2) / (2 R E) (Sneddon 1965, Int.
/// J. Eng. Sci. 3:47), with E = 3 G and nu = 1/2: p pi R / (8 G), of the mean pressure p. The dent springs
/// back by 1.5 times that at most.
void springsBackElastically(const Resolution& resolution, double depth) {
  const Material clay = firm();
  const Dent result = dent(resolution, clay, depth);
  const double recovery = result.pressure * M_PI * radius / (8.0 * clay.stiffness);
  ::testing::Test::RecordProperty("left", std::to_string(result.left / result.deep));
  ::testing::Test::RecordProperty("over_tau_y", std::to_string(result.pressure / yieldStress(clay)));
  EXPECT_GT(result.deep, 0.9 * depth);
  EXPECT_LT(result.deep - result.left, 1.5 * recovery) << "p / tau_y " << result.pressure / yieldStress(clay);
}
TEST_P(Dents, OfTwoMillimetresStay) {
  springsBackElastically(GetParam(), 0.002);
}
class DeepDents : public ::testing::TestWithParam<Resolution> {};
TEST_P(DeepDents, OfEightMillimetresStay) {
  springsBackElastically(GetParam(), 0.008);
}
TEST(DeepDent, OfEightMillimetresStaysAtAThirdOfTheRadius) {
  springsBackElastically({{4, 8}, radius / 3.0}, 0.008);
}

INSTANTIATE_TEST_SUITE_P(Disc, Dents,
                         ::testing::Values(Resolution{{4, 8}, 0.004}, Resolution{{8, 16}, 0.004},
                                           Resolution{{4, 8}, radius / 3.0}),
                         nameOfResolution);
INSTANTIATE_TEST_SUITE_P(Disc, DeepDents,
                         ::testing::Values(Resolution{{4, 8}, 0.004}, Resolution{{8, 16}, 0.004}),
                         nameOfResolution);

/// A flat punch presses with 5 tau_y (Prandtl's 2 + pi in plane strain; a circular punch with 5.69 if it is
/// smooth, Shield 1955, and 6.05 if it is rough, Eason & Shield 1960) to 7 tau_y at a depth of a quarter of
/// its radius, at a spacing of a sixth of the radius.
TEST(Punch, PressesWithFiveToSevenTimesTheYieldStress) {
  const Material clay = firm();
  const Dent result = dent({{4, 8}, radius / 6.0}, clay, 0.25 * radius, false, 0.04, 8.0 * radius / 3.0);
  EXPECT_GT(result.pressure, 5.0 * yieldStress(clay));
  EXPECT_LT(result.pressure, 7.0 * yieldStress(clay));
}

}  // namespace
}  // namespace tactile_clay::clay::dent_test
