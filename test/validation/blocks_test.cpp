#include <gtest/gtest.h>

#include <algorithm>

#include "support/setups.h"

/// Pieces of clay that touch become one, and one that is torn becomes two.
namespace tactile_clay::clay::blocks_test {
namespace {

constexpr double spacing = 0.005;
constexpr int side = 6;  // particles

struct Pair {
  const char* name;
  bool alike;
};
std::vector<Material> materials(const Pair& pair) {
  Material firm, soft;
  firm.yield_strain = 0.05;
  soft.density = 1150.0;
  soft.viscosity = 150.0;
  soft.stiffness = 2e4;
  soft.yield_strain = 0.15;
  for (Material* m : {&firm, &soft}) {
    m->adhesion = 1e7;
    m->friction = 10.0;
  }
  return pair.alike ? std::vector<Material>{firm} : std::vector<Material>{firm, soft};
}

/// Two weightless cubes between a floor and a ceiling, to which they cling. The ceiling brings the upper cube
/// down to the lower one.
class Cubes {
 public:
  explicit Cubes(const std::vector<Material>& of) : clay_(weightless(), of, together(of.size())) {
    ceiling_.pose = Eigen::Translation3d(0.0, 0.0, (2 * side + gap_at_start) * spacing + 0.1);
    // Clay clings only after it was pressed on.
    run(30, -(gap_at_start + 0.2) * spacing / (30 * frame));
    run(30);
  }

  /// @param speed m/s, of the ceiling
  /// @param floor whether there is one
  void run(int frames, double speed = 0.0, bool floor = true) {
    ceiling_.linear_velocity.z() = speed;
    for (int k = 0; k < frames; ++k) {
      clay_.advance({}, floor ? std::vector{ground(), ceiling_} : std::vector{ceiling_}, frame);
      ceiling_.pose.translation().z() += speed * frame;
    }
  }

  int bondsBetween() const {
    const Sculpture s = clay_.sculpture();
    int count = 0;
    for (std::size_t i = 0; i < s.body.size(); ++i)
      for (std::uint32_t b = s.bond_begin[i]; b < s.bond_begin[i + 1]; ++b)
        if (s.body[i] == 0 && s.body[s.bonds[b].other] == 1) ++count;
    return count;
  }
  /// Speed of the lower cube's centre, m/s.
  double lowerSpeed() const {
    const Particles& p = clay_.particles();
    double total = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p.body[i] == 0) total += p.velocity[i].z();
    return total / (side * side * side);
  }
  /// Force between ceiling and floor, N.
  double tension() const { return clay_.solidForces()[0].z(); }
  /// Number of pieces that are out of each other's support radius.
  std::size_t lumps() const { return clay_.statistics().lumps; }

 private:
  static constexpr double frame = 1.0 / 60.0;
  static constexpr double gap_at_start = 1.5;  // spacings; bonds do not reach over it
  static ClayConfig weightless() {
    ClayConfig config;
    config.spacing = spacing;
    config.gravity.setZero();
    config.threads = 2;
    return config;
  }
  static std::vector<InitialParticle> together(std::size_t materials) {
    auto particles = block(side, side, side, spacing);
    const auto upper = block(side, side, side, spacing, {0.001, 0.0, (side + gap_at_start) * spacing},
                             Eigen::Matrix3d::Identity(), static_cast<std::uint8_t>(materials - 1));
    particles.insert(particles.end(), upper.begin(), upper.end());
    for (std::size_t i = 0; i < particles.size(); ++i) particles[i].body = i < particles.size() / 2 ? 0 : 1;
    return particles;
  }

  Clay clay_;
  Solid ceiling_ = ground();
};

class Blocks : public ::testing::TestWithParam<Pair> {};

/// The upper cube carries the lower one.
TEST_P(Blocks, Merge) {
  Cubes cubes(materials(GetParam()));
  EXPECT_GE(cubes.bondsBetween(), side * side);
  cubes.run(60, 0.005, false);
  EXPECT_GE(cubes.bondsBetween(), side * side);
  EXPECT_NEAR(cubes.lowerSpeed(), 0.005, 0.0005);
}

TEST_P(Blocks, HangTogetherByBondsAndViscosity) {
  std::vector<Material> loose = materials(GetParam());
  for (Material& m : loose) m.bond_rate = m.viscosity = 0.0;
  for (const bool merges : {true, false}) {
    Cubes cubes(merges ? materials(GetParam()) : loose);
    cubes.run(2, 0.1);
    if (merges)
      EXPECT_GT(cubes.tension(), 1.0);
    else
      EXPECT_LT(cubes.tension(), 0.1);
  }
}

/// It does not tear where the cubes met: the joint is as strong as the clay beside it.
TEST_P(Blocks, SplitWhenTorn) {
  Cubes cubes(materials(GetParam()));
  ASSERT_GE(cubes.bondsBetween(), side * side);
  ASSERT_EQ(cubes.lumps(), 1u);
  cubes.run(90, 0.1);
  EXPECT_GE(cubes.lumps(), 2u);
  EXPECT_LT(std::abs(cubes.tension()), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Of, Blocks,
                         ::testing::Values(Pair{"OneMaterial", true}, Pair{"TwoMaterials", false}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace tactile_clay::clay::blocks_test
