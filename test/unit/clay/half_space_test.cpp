#include "clay/half_space.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "clouds.h"

namespace tactile_clay::clay {
namespace {

Eigen::Vector3f wayAlong(const std::vector<HalfSpace>& spaces, const std::vector<float>& lengths) {
  Eigen::Vector3f way = Eigen::Vector3f::Zero();
  for (std::size_t k = 0; k < spaces.size(); ++k) way += lengths.at(k) * spaces[k].normal;
  return way;
}

TEST(HalfSpace, OneIsEnteredAlongItsNormal) {
  const std::vector<HalfSpace> spaces{{Eigen::Vector3f::UnitZ(), 0.002f}, {Eigen::Vector3f::UnitX(), -1.0f}};
  const std::vector<float> way = shortestInto(spaces, 1.0f);
  ASSERT_EQ(way.size(), 2u);
  EXPECT_FLOAT_EQ(way[0], 0.002f);
  EXPECT_EQ(way[1], 0.0f);
}

/// Two that face each other at 120 degrees: into both along the line between, at the distance d / sin 30.
TEST(HalfSpace, AWedgeIsLeftAtItsOpening) {
  const float c = std::sqrt(0.75f);
  const std::vector<HalfSpace> spaces{{{0.5f, 0.0f, c}, 0.001f}, {{0.5f, 0.0f, -c}, 0.001f}};
  const Eigen::Vector3f way = wayAlong(spaces, shortestInto(spaces, 1.0f));
  EXPECT_LT((way - Eigen::Vector3f(0.002f, 0.0f, 0.0f)).norm(), 1e-6f);
}

TEST(HalfSpace, ThereIsNoWayBetweenOppositeOnesNorFartherThanAllowed) {
  EXPECT_TRUE(
      shortestInto({{Eigen::Vector3f::UnitX(), 0.001f}, {-Eigen::Vector3f::UnitX(), 0.001f}}, 1.0f).empty());
  EXPECT_TRUE(shortestInto({{Eigen::Vector3f::UnitX(), 0.5f}}, 0.4f).empty());
}

/// The conditions of Karush, Kuhn and Tucker tell the shortest way: into all, along normals of those alone on
/// whose boundary it ends, without pulling.
TEST(HalfSpace, TheWayIntoRandomOnesIsTheShortest) {
  std::mt19937 random(3);
  std::array<int, 4> seen{};  // ways along so many normals
  for (int k = 0; k < 2000; ++k) {
    std::vector<HalfSpace> spaces(2 + k % 5);
    for (HalfSpace& s : spaces) s = {randomVector(random, 1.0f).normalized(), randomVector(random, 1.0f).x()};
    const std::vector<float> lengths = shortestInto(spaces, 10.0f);
    if (lengths.empty()) continue;
    const Eigen::Vector3f way = wayAlong(spaces, lengths);
    int along = 0;
    for (std::size_t s = 0; s < spaces.size(); ++s) {
      const float beyond = spaces[s].normal.dot(way) - spaces[s].least;
      EXPECT_GT(beyond, -2e-3f);
      EXPECT_GE(lengths[s], 0.0f);
      if (lengths[s] == 0.0f) continue;
      EXPECT_LT(beyond, 2e-3f);
      ++along;
    }
    ++seen.at(along);
  }
  for (const int along : {1, 2, 3}) EXPECT_GT(seen[along], 50) << along;
}

}  // namespace
}  // namespace tactile_clay::clay
