#include <gtest/gtest.h>

#include "support/setups.h"

/// Contact force in newtons: a plate rests on clay, with the force on it as its only support.
namespace tactile_clay::clay::plate_test {
namespace {

constexpr double g = 9.81, spacing = 0.005;
constexpr int edge = 6;
constexpr double top = edge * spacing;

/// A plate of solid or of skin on a block of clay on the ground. It falls under its weight and the force that
/// the clay reports for it.
struct Plate {
  Plate(bool of_skin_in, double mass_in)
      : of_skin(of_skin_in),
        mass(mass_in),
        clay(configOf(), {Material()}, block(edge, edge, edge, spacing)) {}

  static ClayConfig configOf() {
    ClayConfig config;
    config.budget = {16, 8};  // an explicit plate wants steps below 2 M / c of block and plate, some 10 ms
    config.threads = 2;
    config.sleeping = false;
    return config;
  }

  void step() {
    const double dt = clay.config().frame / clay.config().budget.substeps;
    Solid solid;
    solid.size = {0.03, 0.03, 0.005};
    solid.pose.translation().z() = height + 0.005;
    solid.linear_velocity.z() = velocity;
    std::vector<Solid> solids{ground()};
    if (!of_skin) solids.push_back(solid);
    height += dt * velocity;
    const Skin skin = of_skin ? samplePlane({0.0, 0.0, height}, -Eigen::Vector3d::UnitZ(), 0.024, 0.004,
                                            {0.0, 0.0, velocity})
                              : Skin();
    clay.advance(skin, solids, dt);
    reading = of_skin ? 0.0 : clay.solidForces()[1].z();
    for (const SkinForce& f : clay.skinForces()) reading += static_cast<double>(f.force.z());
    table = -clay.solidForces()[0].z();
    velocity += dt * (reading / mass - g);
  }

  bool of_skin;
  double mass;  // kg
  Clay clay;
  double height = top, velocity = 0.0;  // m, m/s, of the plate's underside
  double reading = 0.0, table = 0.0;    // N, upwards on the plate, and downwards on the ground
};

/// It comes to rest at the depth that follows from the stiffness of the clay, the force on it is its weight
/// within 2 %, and the ground carries both within 2 %.
class PlateOnClay : public ::testing::TestWithParam<std::tuple<bool, double>> {};
TEST_P(PlateOnClay, ReadsItsWeight) {
  const double mass = std::get<1>(GetParam());
  Plate plate(std::get<0>(GetParam()), mass);
  for (int k = 0; k < 960; ++k) plate.step();
  const double weight = mass * g, both = weight + g * totalMass(plate.clay.particles());
  for (int k = 0; k < 96; ++k) {
    plate.step();
    ASSERT_NEAR(plate.reading, weight, 0.02 * weight);
    ASSERT_NEAR(plate.table, both, 0.02 * both);
  }
  EXPECT_LT(std::abs(plate.velocity), 1e-3);
  // F h / (A E') with the modulus E' = 2.5 E of a cubic lattice with springs E d to 6 + 12 neighbours, and
  // half of the block's own weight.
  const double load = weight + 0.5 * (both - weight);
  const double expected = load / (top * 2.5 * Material().stiffness), sunk = top - plate.height;
  EXPECT_GT(sunk, 0.5 * expected);
  EXPECT_LT(sunk, 1.5 * expected);
}
std::string nameOf(const ::testing::TestParamInfo<std::tuple<bool, double>>& tested) {
  return (std::get<0>(tested.param) ? "Skin" : "Solid") +
         std::to_string(std::lround(1000.0 * std::get<1>(tested.param))) + "Grams";
}
INSTANTIATE_TEST_SUITE_P(Kilograms, PlateOnClay,
                         ::testing::Combine(::testing::Bool(), ::testing::Values(0.05, 0.2)), nameOf);

/// Clay on a plate that is held, and then lifted steadily: the force on the plate is the weight of the clay.
TEST(PlateUnderClay, ReadsTheWeightOfTheClay) {
  ClayConfig config;
  config.threads = 2;
  Clay clay(config, {Material()}, block(edge, edge, edge, spacing));
  const double weight = g * totalMass(clay.particles());
  Solid plate;
  plate.size = {0.04, 0.04, 0.005};
  plate.pose.translation().z() = -0.005;
  for (const double speed : {0.0, 0.05, 0.0}) {
    plate.linear_velocity.z() = speed;
    for (int k = 0; k < 60; ++k) {
      clay.advance({}, {plate}, config.frame);
      plate.pose = poseAfter(plate, config.frame);
    }
    EXPECT_NEAR(-clay.solidForces()[0].z(), weight, 1e-3 * weight) << "at " << speed << " m/s";
  }
}

/// Clay pressed against the underside of a plate hangs there while adhesion carries its weight, rho g h.
TEST(ClayUnderAPlate, HangsByItsAdhesion) {
  for (const double share : {0.5, 2.0}) {
    constexpr int layers = 4;
    Material sticky;
    sticky.adhesion = share * sticky.density * g * layers * spacing;
    ClayConfig config;
    config.threads = 2;
    auto particles = block(layers, layers, layers, spacing);
    for (InitialParticle& p : particles) p.velocity.z() = 0.05f;
    Clay clay(config, {sticky}, particles);
    Solid plate;
    plate.size = {0.04, 0.04, 0.005};
    plate.pose.translation().z() = layers * spacing + 0.005;
    for (int k = 0; k < 30; ++k) clay.advance({}, {plate}, config.frame);
    const double fallen =
        (layers - 0.5) * spacing - extent(clay.particles(), Eigen::Vector3d::UnitZ()).second;
    if (share > 1.0) {
      const double weight = g * totalMass(clay.particles());
      EXPECT_LT(std::abs(fallen), 0.1 * spacing);
      EXPECT_NEAR(-clay.solidForces()[0].z(), weight, 0.01 * weight);
    } else {
      EXPECT_GT(fallen, 0.5);
    }
  }
}

}  // namespace
}  // namespace tactile_clay::clay::plate_test
