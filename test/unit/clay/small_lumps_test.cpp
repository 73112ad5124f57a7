// A grain, a pair, a row and a sheet have no inertia about some axes, or a negative one by rounding. They
// move like all clay, beside clay that is being kneaded.
#include <gtest/gtest.h>

#include <string>

#include "clay/clay.h"
#include "support/setups.h"

namespace tactile_clay::clay::small_lumps_test {
namespace {

struct Small {
  std::string name;
  int nx, ny, nz;
};
const Small smalls[] = {{"grain", 1, 1, 1}, {"pair", 2, 1, 1}, {"row", 7, 1, 1}, {"sheet", 5, 5, 1}};

/// A block that hands press, and a small lump in the air, far from both.
struct Beside {
  Beside(const Small& small, double spacing, const Eigen::Vector3d& at, const Eigen::Vector3d& turn,
         double gravity = -9.81)
      : spacing_(spacing) {
    std::vector<InitialParticle> particles = block(8, 8, 8, spacing);
    first_ = particles.size();
    const Eigen::Matrix3d tilted =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    const Eigen::Vector3d foot = at - tilted * Eigen::Vector3d(0.0, 0.0, 0.5 * spacing);
    for (InitialParticle p : block(small.nx, small.ny, small.nz, spacing, foot, tilted)) {
      p.velocity = turn.cross(p.position.cast<double>() - at).cast<float>();
      particles.push_back(p);
    }
    ClayConfig config;
    config.spacing = spacing;
    config.threads = 1;
    config.gravity.z() = gravity;
    clay_ = std::make_unique<Clay>(config, std::vector<Material>{Material{}}, particles);
    dt_ = config.timeStep();
  }
  /// One frame, in which a palm goes on into the block.
  void advance() {
    const double speed = 2.0 * spacing_ / 0.5, down = speed * ++frames_ / 60.0;
    clay_->advance(samplePlane({0.0, 0.0, 8.2 * spacing_ - down}, -Eigen::Vector3d::UnitZ(), 6.0 * spacing_,
                               0.8 * spacing_, {0.0, 0.0, -speed}),
                   {ground()}, 1.0 / 60.0);
  }
  /// The small lump alone.
  Particles small() const {
    const Particles& all = clay_->particles();
    Particles p;
    const std::size_t n = all.size() - first_;
    p.position.resize(n);
    p.velocity.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      p.position[k] = all.position[first_ + k];
      p.velocity[k] = all.velocity[first_ + k];
      p.inverse_mass.push_back(all.inverse_mass[first_ + k]);
    }
    return p;
  }
  double fallen() const {  // m, in free fall by steps of dt, velocity first
    const double steps = std::round(clay_->time() / dt_);
    return 0.5 * 9.81 * dt_ * dt_ * steps * (steps + 1.0);
  }

  double spacing_, dt_ = 0.0;
  std::size_t first_ = 0;
  int frames_ = 0;
  std::unique_ptr<Clay> clay_;
};

TEST(SmallLumps, FallFreely) {
  for (const Small& small : smalls) {
    for (const double spacing : {0.005, 0.001}) {
      for (const Eigen::Vector3d& at :
           {Eigen::Vector3d(0.08, 0.09, 0.5), Eigen::Vector3d(0.9, -0.93, 0.91)}) {
        SCOPED_TRACE(small.name + " at " + std::to_string(at.x()) + ", spacing " + std::to_string(spacing));
        Beside beside(small, spacing, at, Eigen::Vector3d::Zero());
        const Eigen::Vector3d start = centreOfMass(beside.small());
        for (int k = 0; k < 12; ++k) beside.advance();
        EXPECT_GT(beside.clay_->statistics().iterations, 1.0);  // the block is at work
        const Eigen::Vector3d moved = centreOfMass(beside.small()) - start;
        EXPECT_NEAR(moved.z(), -beside.fallen(), 1e-5);
        EXPECT_LT(moved.head<2>().norm(), 1e-5);
        EXPECT_EQ(beside.clay_->statistics().rejected_displacements, 0U);
      }
    }
  }
}

TEST(SmallLumps, TurnOnAsTheyFall) {
  for (const Small& small : smalls) {
    if (small.nx == 1) continue;  // a grain has nothing that turns
    for (const double at : {0.1, 0.9}) {
      SCOPED_TRACE(small.name + " at " + std::to_string(at));
      Beside beside(small, 0.005, {at, at, 0.5}, {3.0, -4.0, 5.0});
      const Eigen::Vector3d spin = angularMomentum(beside.small()), start = centreOfMass(beside.small());
      for (int k = 0; k < 12; ++k) beside.advance();
      EXPECT_LT((angularMomentum(beside.small()) - spin).norm(), 0.02 * spin.norm());
      EXPECT_NEAR(centreOfMass(beside.small()).z(), start.z() - beside.fallen(), 1e-4);
    }
  }
}

TEST(SmallLumps, ComeToRestOnTheTable) {
  for (const Small& small : smalls) {
    SCOPED_TRACE(small.name);
    Beside beside(small, 0.005, {0.08, 0.09, 0.03}, Eigen::Vector3d::Zero());
    for (int k = 0; k < 30; ++k) beside.advance();
    const Particles p = beside.small();
    for (std::size_t i = 0; i < p.size(); ++i) {
      EXPECT_GT(p.position.at(i).z(), 0.4f * 0.005f);
      EXPECT_LT(p.position.at(i).z(), 0.03f);
    }
    const auto [lowest, highest] = extent(p, Eigen::Vector3d::UnitZ());
    EXPECT_NEAR(lowest, 0.5 * 0.005, 0.1 * 0.005);
  }
}

// What falls beside the table lies at the bottom of the world, and is counted from then on.
TEST(SmallLumps, ThatLeaveTheSceneAreCounted) {
  constexpr double spacing = 0.005;
  std::vector<InitialParticle> particles = block(4, 4, 4, spacing);
  for (const InitialParticle& p : block(3, 1, 1, spacing, {0.3, 0.0, 0.05})) particles.push_back(p);
  ClayConfig config;
  config.spacing = spacing;
  config.world = 0.4;
  Solid table = ground();
  table.size = Eigen::Vector3d(0.2, 0.2, table.size.z());
  Clay clay(config, {Material{}}, particles);
  clay.advance({}, {table}, 1.0 / 60.0);
  EXPECT_EQ(clay.statistics().strays, 0U);
  const double falls = std::sqrt(2.0 * (0.05 + config.world) / 9.81);  // s
  for (int k = 0; k < 60 * (falls + 0.2); ++k) clay.advance({}, {table}, 1.0 / 60.0);
  EXPECT_EQ(clay.statistics().strays, 3U);
}

TEST(SmallLumps, AreCounted) {
  Beside beside(smalls[2], 0.005, {0.1, 0.1, 0.4}, Eigen::Vector3d::Zero());
  beside.advance();
  EXPECT_EQ(beside.clay_->statistics().lumps, 2U);
  EXPECT_EQ(beside.clay_->statistics().crumbs, 1U);
  EXPECT_GE(beside.clay_->statistics().rounds, 1.0);
}

}  // namespace
}  // namespace tactile_clay::clay::small_lumps_test
