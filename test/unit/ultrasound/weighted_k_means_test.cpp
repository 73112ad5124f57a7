#include "ultrasound/weighted_k_means.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>

namespace tactile_clay::ultrasound::weighted_k_means_test {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Eq. 8 of a given partition, each cluster about its own weighted mean.
double objective(const Points& x, const std::vector<double>& w, const std::vector<std::size_t>& cluster,
                 std::size_t k) {
  double sum = 0.0;
  for (std::size_t c = 0; c < k; ++c) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double total = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (cluster[i] != c) continue;
      mean += w[i] * x[i];
      total += w[i];
    }
    if (total == 0.0) continue;
    mean /= total;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (cluster[i] == c) sum += w[i] * (x[i] - mean).squaredNorm();
    }
  }
  return sum;
}

/// The optimum of Eq. 8, by trying all k^n partitions.
double bruteForce(const Points& x, const std::vector<double>& w, std::size_t k) {
  std::vector<std::size_t> cluster(x.size(), 0);
  double best = std::numeric_limits<double>::infinity();
  while (true) {
    best = std::min(best, objective(x, w, cluster, k));
    std::size_t i = 0;
    while (i < x.size() && ++cluster[i] == k) cluster[i++] = 0;
    if (i == x.size()) return best;
  }
}

void randomSamples(std::mt19937& random, std::size_t n, Points& x, std::vector<double>& w) {
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  std::uniform_real_distribution<double> strength(0.05, 1.0);
  x.clear();
  w.clear();
  for (std::size_t i = 0; i < n; ++i) {
    x.emplace_back(place(random), place(random), 0.2 + 0.2 * place(random));
    w.push_back(strength(random));
  }
}

TEST(WeightedKMeans, IsTheBruteForceOptimumOnSmallCases) {
  std::mt19937 random(4);
  int cases = 0;
  int equal = 0;
  for (int trial = 0; trial < 40; ++trial) {
    for (std::size_t n = 3; n <= 8; ++n) {
      for (std::size_t k = 1; k <= 3; ++k) {
        Points x;
        std::vector<double> w;
        randomSamples(random, n, x, w);
        const Clustering found = weightedKMeans(x, w, k);
        const double best = bruteForce(x, w, k);
        EXPECT_NEAR(found.objective, objective(x, w, found.cluster, k), 1e-12);
        EXPECT_GE(found.objective, best - 1e-12);
        EXPECT_LE(found.objective, 1.05 * best + 1e-12) << "n " << n << ", k " << k << ", trial " << trial;
        ++cases;
        equal += found.objective <= best * (1.0 + 1e-9) + 1e-15 ? 1 : 0;
      }
    }
  }
  RecordProperty("optimal", equal);
  RecordProperty("cases", cases);
  EXPECT_GE(equal, cases * 98 / 100) << equal << " of " << cases << " optimal";
}

TEST(WeightedKMeans, CentresAreWeightedMeansOfTheirVoronoiCells) {
  std::mt19937 random(5);
  Points x;
  std::vector<double> w;
  randomSamples(random, 300, x, w);
  const Clustering found = weightedKMeans(x, w, 8);
  ASSERT_EQ(found.centre.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double total = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (found.cluster[i] != k) continue;
      sum += w[i] * x[i];
      total += w[i];
    }
    EXPECT_LT((sum / total - found.centre[k]).norm(), 1e-12);
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double own = (x[i] - found.centre[found.cluster[i]]).norm();
    for (const auto& centre : found.centre) EXPECT_LE(own, (x[i] - centre).norm() + 1e-12);
  }
}

TEST(WeightedKMeans, FollowsTheWeights) {
  // One cluster of two samples: the mean lies at 3/4 of the way to the one three times as heavy.
  const Clustering found = weightedKMeans({{0, 0, 0}, {1, 0, 0}}, {1.0, 3.0}, 1);
  ASSERT_EQ(found.centre.size(), 1u);
  EXPECT_NEAR(found.centre[0].x(), 0.75, 1e-15);
  EXPECT_NEAR(found.objective, 0.75, 1e-15);
}

TEST(WeightedKMeans, OfNothingOrOfOneIsTrivial) {
  EXPECT_TRUE(weightedKMeans({}, {}, 3).centre.empty());
  EXPECT_TRUE(weightedKMeans({{0, 0, 0}}, {1.0}, 0).centre.empty());
  const Clustering one = weightedKMeans({{1, 2, 3}}, {0.5}, 3);
  ASSERT_EQ(one.centre.size(), 1u);
  EXPECT_EQ(one.centre[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(one.objective, 0.0);
}

TEST(WeightedKMeans, OfCoincidentSamplesIsOneCluster) {
  const Clustering found =
      weightedKMeans(Points(5, Eigen::Vector3d(1, 2, 3)), std::vector<double>(5, 1.0), 3);
  EXPECT_EQ(found.centre.size(), 1u);
}

TEST(WeightedKMeans, SeedsKeepTheirSeparation) {
  std::mt19937 random(6);
  Points x;
  std::vector<double> w;
  randomSamples(random, 200, x, w);
  const Points seeds = addSeeds(x, w, {x[0]}, 100, 0.02);
  EXPECT_GT(seeds.size(), 8u);
  EXPECT_LT(seeds.size(), 100u);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((seeds[i] - seeds[j]).norm(), 0.02);
  }
}

TEST(WeightedKMeans, SeedsTakeTheLowerIndexOfATie) {
  const Points seeds = addSeeds({{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}}, {1, 1, 1}, {{0, 0, 0}}, 2, 0.0);
  ASSERT_EQ(seeds.size(), 2u);
  EXPECT_EQ(seeds[1], Eigen::Vector3d(1, 0, 0));
}

TEST(WeightedKMeans, DropsACentreWithoutSamples) {
  const Clustering found = refineClusters({{0, 0, 0}, {1, 0, 0}}, {1, 1}, {{0.5, 0, 0}, {50, 0, 0}});
  EXPECT_EQ(found.centre.size(), 1u);
}

TEST(WeightedKMeans, RefusesBadArguments) {
  EXPECT_THROW(weightedKMeans({{0, 0, 0}}, {}, 1), std::invalid_argument);
  EXPECT_THROW(refineClusters({{0, 0, 0}}, {1}, {}), std::invalid_argument);
  EXPECT_THROW(addSeeds({{0, 0, 0}}, {1}, {}, 1, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::weighted_k_means_test
