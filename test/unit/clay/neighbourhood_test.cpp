#include "clay/neighbourhood.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>

#include "clouds.h"

namespace tactile_clay::clay {
namespace {

constexpr float h = 0.01f;

using Pair = std::pair<std::uint32_t, std::uint32_t>;

std::set<Pair> bruteForce(const VectorField& x) {
  std::set<Pair> pairs;
  for (std::uint32_t i = 0; i < x.size(); ++i) {
    for (std::uint32_t j = 0; j < x.size(); ++j) {
      const float dx = x.x[i] - x.x[j], dy = x.y[i] - x.y[j], dz = x.z[i] - x.z[j];
      if (i != j && dx * dx + dy * dy + dz * dz < h * h) pairs.insert({i, j});
    }
  }
  return pairs;
}

/// Lists hold exactly the pairs of brute force, with their offsets; padding is beyond every kernel.
void expectExact(const std::vector<Eigen::Vector3f>& points) {
  const VectorField x = toField(points);
  Neighbourhood near(h);
  near.build(x);
  std::set<Pair> found;
  for (std::uint32_t i = 0; i < x.size(); ++i) {
    ASSERT_EQ((near.end(i) - near.begin(i)) % 8, 0u);
    ASSERT_LE(near.begin(i) + near.count(i), near.end(i));
    ASSERT_LT(near.end(i) - near.begin(i), near.count(i) + 8);
    ASSERT_LE(near.end(i), near.pairs());
    for (std::uint32_t p = near.begin(i); p < near.begin(i) + near.count(i); ++p) {
      const std::uint32_t j = near.other()[p];
      EXPECT_TRUE(found.insert({i, j}).second) << "pair twice: " << i << " " << j;
      EXPECT_EQ(near.offset().at(p), x.at(i) - x.at(j));
    }
    for (std::uint32_t p = near.begin(i) + near.count(i); p < near.end(i); ++p) {
      EXPECT_EQ(near.other()[p], i);
      EXPECT_GE(near.offset().at(p).norm(), h);
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
  std::uint32_t most = 0;
  for (std::size_t i = 0; i < points.size(); ++i) most = std::max(most, near.count(i));
  EXPECT_GT(most, 60u);
}

TEST(Neighbourhood, ForEachNearFindsAllInTheBall) {
  std::mt19937 random(6);
  const std::vector<Eigen::Vector3f> points = lattice(8, 0.5f * h, 0.4f, 6);
  Neighbourhood near(h);
  near.build(toField(points));
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3f centre = randomVector(random, 0.03f);
    const float radius = 0.002f + 0.0005f * static_cast<float>(k);
    std::multiset<std::uint32_t> found;
    near.forEachNear(centre, radius, [&](std::uint32_t i) { found.insert(i); });
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      EXPECT_LE(found.count(i), 1u);
      if ((points[i] - centre).norm() <= radius) {
        EXPECT_EQ(found.count(i), 1u);
      }
    }
  }
}

TEST(Neighbourhood, EveryParticleIsVisitedOnce) {
  const std::vector<Eigen::Vector3f> points = lattice(9, 0.5f * h, 0.3f, 7);
  Neighbourhood near(h);
  near.build(toField(points));
  std::mutex mutex;
  std::multiset<std::uint32_t> visited;
  near.forEachColoured([&](std::uint32_t i) {
    const std::lock_guard<std::mutex> lock(mutex);
    visited.insert(i);
  });
  ASSERT_EQ(visited.size(), points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) EXPECT_EQ(visited.count(i), 1u);
}

TEST(Neighbourhood, BlocksOfOneColourShareNoNeighbour) {
  const std::vector<Eigen::Vector3f> points = lattice(12, 0.5f * h, 0.3f, 8);
  const VectorField x = toField(points);
  Neighbourhood near(h);
  near.build(x);
  // Block and colour of a particle, worked out anew from the documented layout: cells of edge h (a hair more)
  // from the lowest corner, blocks of 2x2x2 cells, colour by the parity of the block.
  const float low[3] = {*std::min_element(x.x.begin(), x.x.end()), *std::min_element(x.y.begin(), x.y.end()),
                        *std::min_element(x.z.begin(), x.z.end())};
  const auto blockOf = [&](std::uint32_t i) {
    std::array<int, 3> block{};
    for (int a = 0; a < 3; ++a) {
      block[a] = static_cast<int>(std::floor((points[i][a] - low[a]) / (h * 1.0001f))) / 2;
    }
    return block;
  };
  const auto colourOf = [](const std::array<int, 3>& b) {
    return (b[0] & 1) | (b[1] & 1) << 1 | (b[2] & 1) << 2;
  };
  std::vector<std::uint32_t> order;
  {
    const tbb::global_control serial(tbb::global_control::max_allowed_parallelism, 1);
    near.forEachColoured([&](std::uint32_t i) { order.push_back(i); });
  }
  ASSERT_EQ(order.size(), points.size());
  for (std::size_t k = 1; k < order.size(); ++k) {
    ASSERT_LE(colourOf(blockOf(order[k - 1])), colourOf(blockOf(order[k]))) << "not in the order of colours";
  }
  // touched[j]: the block of each colour that writes to particle j (itself or as a neighbour)
  std::map<std::pair<int, std::uint32_t>, std::array<int, 3>> touched;
  std::set<int> colours;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto block = blockOf(i);
    const int colour = colourOf(block);
    colours.insert(colour);
    const auto touch = [&](std::uint32_t j) {
      const auto entry = touched.insert({{colour, j}, block}).first;
      EXPECT_EQ(entry->second, block) << "particle " << j << " is written by two blocks of colour " << colour;
    };
    touch(i);
    for (std::uint32_t p = near.begin(i); p < near.begin(i) + near.count(i); ++p) touch(near.other()[p]);
  }
  EXPECT_EQ(colours.size(), 8u);
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
      EXPECT_EQ(near.lump(near.other()[p]), near.lump(i));
    }
  }
  EXPECT_NE(near.lump(0), near.lump(first));
}

}  // namespace
}  // namespace tactile_clay::clay
