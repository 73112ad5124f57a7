#include "clay/solver/lumps.h"

#include <gtest/gtest.h>

#include "clouds.h"
#include "support/setups.h"

namespace tactile_clay::clay::lumps_test {
namespace {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f, particle_mass = 2e-4f;
constexpr int edge = 5;

/// Two cubes of clay, far from each other, as the lumps 0 and 1; the first stands on a floor.
struct TwoCubes {
  TwoCubes() {
    std::vector<Eigen::Vector3f> points;
    for (const float x : {0.0f, 0.2f})
      for (const Eigen::Vector3f& p : lattice(edge, spacing, 0.0f))
        points.push_back(p + Eigen::Vector3f(x, 0.0f, 0.5f * edge * spacing));
    particles = particlesAt(points, particle_mass);
    free = zeros(particles.size());
    near.build(particles.position);
    lumps.measure(in);
  }
  std::size_t cube(std::size_t i) const { return i / (edge * edge * edge); }
  Eigen::Vector3f centre(std::size_t c) const { return {c == 0 ? 0.0f : 0.2f, 0.0f, 0.5f * edge * spacing}; }
  /// Detects contacts with the floor, whose top is `below` under the cubes, and leaves them open.
  void detect(const VectorField& guess, float below = 0.0f) {
    Solid floor = ground();
    floor.pose.translation().z() -= below;
    const std::vector<Solid> solids{floor};
    const std::vector<Eigen::Isometry3d> poses{floor.pose};
    contacts.detect(near, particles, guess, {samples, solids, poses, poses, dt});
  }
  /// Changes all contacts: change(contact).
  template <typename F>
  void changeContacts(const F& change) {
    std::vector<Contact> changed = contacts.contacts();
    for (Contact& c : changed) change(c);
    contacts.restore(changed);
  }
  /// A rigid displacement of each cube about its centre.
  VectorField rigid(const Eigen::Vector3f& translation, const Eigen::Vector3f& rotation) const {
    VectorField u = zeros(particles.size());
    for (std::size_t i = 0; i < u.size(); ++i)
      u.set(i, translation + rotation.cross(particles.position.at(i) - centre(cube(i))));
    return u;
  }

  Particles particles;
  Neighbourhood near{2.0f * spacing};
  Skin samples;
  Contacts contacts{spacing, {Material{}}};
  VectorField free;  // m
  StepInput in{near, particles, nullptr, free, dt};
  Lumps lumps{spacing};
};

TEST(Lumps, HaveTheirCentres) {
  const TwoCubes two;
  ASSERT_EQ(two.near.lumps(), 2u);
  for (std::size_t i = 0; i < two.particles.size(); ++i) {
    const Eigen::Vector3d centre = two.centre(two.cube(i)).cast<double>();
    EXPECT_LT((two.lumps.centreAt(two.in, i) - centre).norm(), 1e-8);
    EXPECT_LT((two.lumps.armOf(two.in, i) - (two.particles.position.at(i).cast<double>() - centre)).norm(),
              1e-8);
  }
}

/// Velocities are chords of the last step, (1 - R^-1) arm / dt; a body that goes on to turn moves by (R - 1)
/// arm.
TEST(Lumps, BendsKeepTheSizeOfALumpThatTurns) {
  for (const double angle : {0.01, 0.1, 0.4}) {
    TwoCubes two;
    const Eigen::Matrix3f turn = Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, -2.0, 0.5).normalized())
                                     .toRotationMatrix()
                                     .cast<float>();
    const auto arm = [&](std::size_t i) -> Eigen::Vector3f {
      return two.particles.position.at(i) - two.centre(two.cube(i));
    };
    for (std::size_t i = 0; i < two.particles.size(); ++i) {
      if (two.cube(i) == 0) two.particles.velocity.set(i, (arm(i) - turn.transpose() * arm(i)) / dt);
    }
    const std::vector<Eigen::Matrix3f> bends = two.lumps.bends(two.in);
    ASSERT_EQ(bends.size(), 2u);
    EXPECT_EQ(bends[two.near.lump(two.particles.size() - 1)].norm(), 0.0f);  // rests
    for (std::size_t i = 0; i < edge * edge * edge; ++i) {
      const Eigen::Vector3f next =
          arm(i) + dt * two.particles.velocity.at(i) + bends[two.near.lump(i)] * arm(i);
      EXPECT_LT((next - turn * arm(i)).norm(), 1e-4f * spacing) << angle;
    }
  }
}

TEST(Lumps, FallByWhatInertiaAsksWhereNothingIsTouched) {
  TwoCubes two;
  const VectorField u = zeros(two.particles.size());
  for (std::size_t i = 0; i < two.free.size(); ++i)  // the mean is what counts
    two.free.set(i, {1e-4f, 0.0f, (i % 2 == 0 ? -2e-4f : -4e-4f) * static_cast<float>(two.cube(i))});
  two.detect(two.free, 0.1f);
  const std::vector<Eigen::Vector3f> falls = two.lumps.falls(two.in, u, two.contacts);
  ASSERT_EQ(falls.size(), 2u);
  const float even = 62.0f / 125.0f;  // share of the particles with an even number in the second cube
  EXPECT_NEAR((falls[two.near.lump(0)] - Eigen::Vector3f(1e-4f, 0.0f, 0.0f)).norm(), 0.0f, 1e-9f);
  const Eigen::Vector3f second(1e-4f, 0.0f, -2e-4f * even - 4e-4f * (1.0f - even));
  EXPECT_NEAR((falls[two.near.lump(125)] - second).norm(), 0.0f, 1e-9f);
}

TEST(Lumps, FallsHaveNothingAlongWhatAContactBlocks) {
  TwoCubes two;
  two.free = two.rigid({1e-4f, 2e-4f, -3e-4f}, Eigen::Vector3f::Zero());
  two.detect(two.free);
  ASSERT_EQ(two.contacts.contacts().size(), 2u * edge * edge);
  two.changeContacts([&](Contact& c) {
    if (two.cube(c.particle) == 0) {
      c.state = Contact::State::slide;
      c.friction.setZero();
    }
  });
  const VectorField u = zeros(two.particles.size());
  const std::vector<Eigen::Vector3f> falls = two.lumps.falls(two.in, u, two.contacts);
  EXPECT_LT((falls[two.near.lump(0)] - Eigen::Vector3f(1e-4f, 2e-4f, 0.0f)).norm(), 1e-9f);
  EXPECT_LT((falls[two.near.lump(125)] - Eigen::Vector3f(1e-4f, 2e-4f, -3e-4f)).norm(), 1e-9f);
}

/// A lump flies half a spacing over a floor, and would fall by a whole one.
TEST(Lumps, MeetTheFloorWhereTheyFirstTouchIt) {
  TwoCubes two;
  const VectorField u = zeros(two.particles.size());
  const VectorField guess = two.rigid({0.0f, 0.0f, -spacing}, Eigen::Vector3f::Zero());
  two.detect(guess, 0.5f * spacing);
  std::vector<Eigen::Vector3f> moves(2, Eigen::Vector3f(0.0f, 0.0f, -spacing));
  two.contacts.close(two.lumps.meet(two.in, u, two.contacts, moves));
  for (const Eigen::Vector3f& move : moves) EXPECT_NEAR(move.z(), -0.5f * spacing, 1e-3f * spacing);
  for (const Contact& c : two.contacts.contacts()) {  // those of the lowest layer close
    const bool lowest = two.particles.position.at(c.particle).z() < spacing;
    EXPECT_EQ(c.state == Contact::State::slide, lowest) << c.particle;
  }
  // Away from it, or by less than a quarter of a spacing, nothing is shortened.
  TwoCubes others;
  others.detect(guess, 0.05f * spacing);
  moves = {{0.0f, 0.0f, spacing}, {0.0f, 0.0f, -0.2f * spacing}};
  const std::vector<Eigen::Vector3f> asked = moves;
  EXPECT_TRUE(others.lumps.meet(others.in, u, others.contacts, moves).empty());
  EXPECT_EQ(moves, asked);
}

TEST(Lumps, ContactsLeaveTheRigidMotionsThatTheyDoNotBlock) {
  TwoCubes two;
  const VectorField u = zeros(two.particles.size());
  two.detect(u);
  const auto motions = [&](const auto& state_of) {
    two.changeContacts([&](Contact& c) { c.state = state_of(c); });
    return two.lumps.unblockedMotions(two.in, u, two.contacts)[two.near.lump(0)].basis.cols();
  };
  using State = Contact::State;
  std::uint32_t first = two.contacts.contacts().front().particle;
  EXPECT_EQ(motions([](const Contact&) { return State::open; }), 6);
  // on a smooth floor: along it, and about its normal
  EXPECT_EQ(motions([](const Contact&) { return State::slide; }), 3);
  EXPECT_EQ(motions([](const Contact&) { return State::stick; }), 0);
  // about a point that sticks
  EXPECT_EQ(motions([&](const Contact& c) { return c.particle == first ? State::stick : State::open; }), 3);
}

TEST(Lumps, ARigidDisplacementIsFoundInTheUnblockedMotions) {
  TwoCubes two;
  const Eigen::Vector3f translation(1e-4f, -2e-4f, 3e-4f), rotation(0.01f, 0.02f, -0.015f);
  const VectorField u = two.rigid(translation, rotation);
  two.detect(u, 0.1f);
  for (const Lumps::Unblocked& motion : two.lumps.unblockedMotions(two.in, u, two.contacts)) {
    EXPECT_LT((motion.done.translation - translation.cast<double>()).norm(), 1e-8);
    EXPECT_LT((motion.done.rotation - rotation.cast<double>()).norm(), 1e-6);
  }
}

/// Work of pushing out, computed by hand; for solids, only the part that exceeds the recovery speed.
TEST(Lumps, WorkOfContactsIsThatOfTheirForcesOverTheirGaps) {
  TwoCubes two;
  two.detect(zeros(two.particles.size()));
  const float push = 0.5f;  // N
  two.changeContacts([&](Contact& c) {
    c.gap = two.cube(c.particle) == 0 ? 2e-4f : -2e-4f;
    c.force = Eigen::Vector3f(0.3f, 0.0f, push);
  });
  const std::vector<double> work = two.lumps.workOfPushingOut(two.in, two.contacts);
  EXPECT_NEAR(work[two.near.lump(0)], edge * edge * 2e-4 * push, 1e-9);
  EXPECT_EQ(work[two.near.lump(125)], 0.0);
  // The least gap that a solid may recover in a step is its limit.
  const float limit = static_cast<float>(ContactSearch::solid_recovery_speed) * dt;
  const auto recovery = [&](float gap) {
    two.changeContacts([&](Contact& c) { c.gap = gap; });
    return two.lumps.workOfRecovery(two.in, two.contacts)[two.near.lump(0)];
  };
  EXPECT_EQ(recovery(0.9f * limit), 0.0);
  EXPECT_NEAR(recovery(1.1f * limit), edge * edge * 1.1 * limit * push, 1e-6);
}

TEST(Lumps, SlideOnWhatRestsOnlyWithoutFriction) {
  TwoCubes two;
  two.detect(zeros(two.particles.size()));
  two.changeContacts([&](Contact& c) {
    c.state = two.cube(c.particle) == 0 ? Contact::State::slide : Contact::State::open;
    c.stiffness = 0.0f;
  });
  const std::size_t on = two.near.lump(0), off = two.near.lump(125);
  EXPECT_TRUE(two.lumps.slideOnWhatRests(two.in, two.contacts)[on]);
  EXPECT_FALSE(two.lumps.slideOnWhatRests(two.in, two.contacts)[off]);  // touches nothing
  const std::uint32_t one = two.contacts.contacts().front().particle;
  ASSERT_EQ(two.cube(one), 0u);
  two.changeContacts([&](Contact& c) {
    if (c.particle == one) c.drift = Eigen::Vector3f(spacing, 0.0f, 0.0f);  // of a solid that moves
  });
  EXPECT_FALSE(two.lumps.slideOnWhatRests(two.in, two.contacts)[on]);
  two.changeContacts([&](Contact& c) {
    c.drift.setZero();
    if (c.particle == one) c.stiffness = 1.0f;  // with friction
  });
  EXPECT_FALSE(two.lumps.slideOnWhatRests(two.in, two.contacts)[on]);
}

}  // namespace
}  // namespace tactile_clay::clay::lumps_test
