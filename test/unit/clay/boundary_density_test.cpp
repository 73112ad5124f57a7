#include "clay/forces/boundary_density.h"

#include <gtest/gtest.h>

#include "clay/lattice.h"

namespace tactile_clay::clay::boundary_density_test {
namespace {

constexpr float spacing = 0.005f;

Contact on(std::uint32_t particle, std::uint32_t solid, const Eigen::Vector3f& normal,
           Contact::State state = Contact::State::stick) {
  Contact c;
  c.particle = particle;
  c.solid = solid;
  c.normal = normal;
  c.state = state;
  return c;
}

class Boundary : public ::testing::Test {
 protected:
  Boundary() { liquid_.stiffness = 0.0; }
  /// The share of a particle of the given density with these contacts.
  float share(float ratio, const std::vector<Contact>& contacts) {
    particles_.material.assign(1, 0);
    BoundaryDensity of_solids = density();
    const auto& shares = of_solids.update(particles_, {ratio}, contacts);
    return shares.empty() ? 0.0f : shares.front().ratio;
  }
  BoundaryDensity density() const { return {kernel_, spacing, {liquid_}}; }

  Kernel kernel_{2.0f * spacing};
  Material liquid_;
  Particles particles_;
};

/// Sum of the lattice over x >= 0, y >= 0, z >= 0; as many of these conditions count as there are walls.
float latticeBeside(const Kernel& kernel, int walls) {
  float sum = 0.0f;
  for (int x = walls > 0 ? 0 : -2; x <= 2; ++x)
    for (int y = walls > 1 ? 0 : -2; y <= 2; ++y)
      for (int z = walls > 2 ? 0 : -2; z <= 2; ++z)
        sum += kernel.value(spacing * std::sqrt(static_cast<float>(x * x + y * y + z * z)));
  return sum / latticeSum(kernel, spacing);
}

TEST_F(Boundary, GivesWhatTheLatticeLacksAtAWallAnEdgeAndInACorner) {
  std::vector<Contact> contacts;
  for (int walls = 1; walls <= 3; ++walls) {
    contacts.push_back(on(0, walls, Eigen::Vector3f::Unit(walls - 1)));
    const float lattice = latticeBeside(kernel_, walls);
    EXPECT_NEAR(lattice + share(0.0f, contacts), 1.0f, walls == 1 ? 1e-6f : 0.01f) << walls;
  }
}

TEST_F(Boundary, CountsOneOfTwoOnTheSameSide) {
  const Contact table = on(0, 0, Eigen::Vector3f::UnitZ()), other = on(0, 1, Eigen::Vector3f::UnitZ());
  EXPECT_FLOAT_EQ(share(0.0f, {table, other}), share(0.0f, {table}));
}

TEST_F(Boundary, CompressesNobody) {
  const Contact table = on(0, 0, Eigen::Vector3f::UnitZ());
  EXPECT_NEAR(share(0.95f, {table}), 0.05f, 1e-6f);
  EXPECT_EQ(share(1.02f, {table}), 0.0f);
}

TEST_F(Boundary, IsKeptUntilTheContactOpens) {
  BoundaryDensity kept = density();
  particles_.material.assign(1, 0);
  std::vector<Contact> contacts{on(0, 0, Eigen::Vector3f::UnitZ())};
  const auto first = kept.update(particles_, {0.9f}, contacts);
  ASSERT_EQ(first.size(), 1u);
  contacts[0].density = first.front().ratio;
  const auto then = kept.update(particles_, {1.1f}, contacts);
  ASSERT_EQ(then.size(), 1u);
  EXPECT_FLOAT_EQ(then.front().ratio, first.front().ratio);
  contacts[0].state = Contact::State::open;
  EXPECT_TRUE(kept.update(particles_, {0.9f}, contacts).empty());
}

TEST_F(Boundary, IsNotOfTheSkinNorForWhatHasBonds) {
  EXPECT_EQ(share(0.5f, {on(0, Contact::skin, Eigen::Vector3f::UnitZ())}), 0.0f);
  liquid_.stiffness = 1e5;
  EXPECT_EQ(share(0.5f, {on(0, 0, Eigen::Vector3f::UnitZ())}), 0.0f);
}

}  // namespace
}  // namespace tactile_clay::clay::boundary_density_test
