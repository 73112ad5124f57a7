#include "clay/neighbourhood.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "clouds.h"

namespace tactile_clay::clay::neighbourhood_test {
namespace {

constexpr float h = 0.01f;

using Pair = std::pair<std::uint32_t, std::uint32_t>;

std::set<Pair> bruteForce(const VectorField& x) {
  std::set<Pair> pairs;
  for (std::uint32_t i = 0; i < x.size(); ++i) {
    for (std::uint32_t j = 0; j < x.size(); ++j) {
      if (i != j && (x.at(i) - x.at(j)).norm() < h) pairs.insert({i, j});
    }
  }
  return pairs;
}

/// Lists hold exactly the pairs of brute force, with their offsets.
void expectExact(const std::vector<Eigen::Vector3f>& points) {
  const VectorField x = toField(points);
  Neighbourhood near(h);
  near.build(x);
  std::set<Pair> found;
  for (std::uint32_t i = 0; i < x.size(); ++i) {
    ASSERT_EQ(near.begin(i) + near.count(i), near.end(i));
    ASSERT_LE(near.end(i), near.pairs());
    for (std::uint32_t p = near.begin(i); p < near.begin(i) + near.count(i); ++p) {
      const std::uint32_t j = near.other(p);
      EXPECT_TRUE(found.insert({i, j}).second) << "pair twice: " << i << " " << j;
      EXPECT_EQ(near.offset(p), x.at(i) - x.at(j));
    }
  }
  EXPECT_EQ(found, bruteForce(x));
}

TEST(Neighbourhood, EqualsBruteForceOnRandomClouds) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 400; ++i) points.push_back(randomVector(random, 0.03f));
    expectExact(points);
  }
}

TEST(Neighbourhood, EqualsBruteForceOnTheLatticeOfTheStart) {
  // spacings that divide the support put pairs exactly at its edge and particles exactly on cell faces
  expectExact(lattice(7, 0.5f * h, 0.0f));
  expectExact(lattice(5, h, 0.0f));
}

TEST(Neighbourhood, StrayParticlesFarAwayCostNoMemoryAndLoseNoPair) {
  std::mt19937 random(4);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 300; ++i) points.push_back(randomVector(random, 0.02f));
  points.emplace_back(1e6f, -1e6f, 1e6f);
  points.emplace_back(-1e3f, 1e3f, 0.0f);
  points.emplace_back(-1e3f, 1e3f, 0.0f);
  expectExact(points);
}

TEST(Neighbourhood, CrumbsFarAwayDoNotEnlargeTheGrid) {
  std::vector<Eigen::Vector3f> points = lattice(8, 0.5f * h, 0.2f);
  Neighbourhood near(h);
  near.build(toField(points));
  const std::size_t cells = near.cells();
  const std::vector<Eigen::Vector3f> crumbs = {{0.9f, 0.9f, -0.9f}, {-0.9f, 0.3f, -0.9f}, {0.0f, 0.0f, 0.9f}};
  points.insert(points.end(), crumbs.begin(), crumbs.end());
  near.build(toField(points));
  EXPECT_LE(near.cells(), cells + 100);
  EXPECT_EQ(near.lumps(), 4u);
  expectExact(points);
}

TEST(Neighbourhood, CoincidentParticlesAreNeighbours) {
  std::vector<Eigen::Vector3f> points = lattice(3, 0.5f * h, 0.1f);
  points.insert(points.end(), 5, Eigen::Vector3f(0.001f, 0.002f, 0.0f));
  expectExact(points);
}

TEST(Neighbourhood, NothingAndASingleParticle) {
  expectExact({});
  expectExact({Eigen::Vector3f(0.1f, 0.2f, 0.3f)});
}

TEST(Neighbourhood, HasNoCap) {
  std::mt19937 random(5);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 300; ++i) points.push_back(randomVector(random, 0.35f * h));
  expectExact(points);
  Neighbourhood near(h);
  near.build(toField(points));
  std::uint32_t maximum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) maximum = std::max(maximum, near.count(i));
  EXPECT_GT(maximum, 60u);
}

TEST(Neighbourhood, ForEachRunFindsAllInTheBox) {
  std::mt19937 random(6);
  const std::vector<Eigen::Vector3f> points = lattice(8, 0.5f * h, 0.4f, 6);
  Neighbourhood near(h);
  near.build(toField(points));
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3f centre = randomVector(random, 0.03f);
    const float radius = 0.002f + 0.0005f * static_cast<float>(k);
    std::multiset<std::uint32_t> found;
    const Eigen::Vector3f half = radius * Eigen::Vector3f(1.0f, 0.5f, 2.0f);
    near.forEachRun(centre - half, centre + half, [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t p = from; p < to; ++p) {
        const std::uint32_t i = near.places().slot[p] / slot_size;
        found.insert(i);
        EXPECT_EQ(points[i], Eigen::Vector3f(near.places().x[p], near.places().y[p], near.places().z[p]));
      }
    });
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      EXPECT_LE(found.count(i), 1u);
      if (((points[i] - centre).cwiseAbs().array() <= half.array()).all()) {
        EXPECT_EQ(found.count(i), 1u);
      }
    }
  }
}

TEST(Neighbourhood, LumpsAreApartAndHoldTheirPairs) {
  std::vector<Eigen::Vector3f> points = lattice(4, 0.5f * h, 0.2f);
  const std::size_t first = points.size();
  for (Eigen::Vector3f x : lattice(3, 0.5f * h, 0.2f))
    points.push_back(x + Eigen::Vector3f(0.2f, 0.0f, 0.0f));
  Neighbourhood near(h);
  near.build(toField(points));
  EXPECT_EQ(near.lumps(), 2u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(near.lump(i), near.lump(i < first ? 0 : first));
    for (std::uint32_t p = near.begin(i); p < near.begin(i) + near.count(i); ++p) {
      EXPECT_EQ(near.lump(near.other(p)), near.lump(i));
    }
  }
  EXPECT_NE(near.lump(0), near.lump(first));
}

}  // namespace
}  // namespace tactile_clay::clay::neighbourhood_test
