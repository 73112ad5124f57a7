#include "ultrasound/weighted_k_means.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace tactile_clay::ultrasound {
namespace {

constexpr int max_passes = 100;  // Lloyd needs some ten on a hand; the cap bounds the worst case

std::size_t closest(const std::vector<Eigen::Vector3d>& centre, const Eigen::Vector3d& x) {
  std::size_t best = 0;
  double best_distance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < centre.size(); ++k) {
    const double distance = (centre[k] - x).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best = k;
    }
  }
  return best;
}

using Positions = std::vector<Eigen::Vector3d>;
using ClusterWeights = std::vector<double>;

/// Clusters with their weights, from which the gain of an exchange is computed.
struct Clusters {
  std::vector<std::size_t> cluster;  // of each sample
  Positions centre;
  ClusterWeights total;  // weight of each cluster
};

/// Moves each centre to the mean of its samples, and removes centres without samples.
void updateCentres(const Positions& position, const ClusterWeights& weight, Clusters& c) {
  Positions sum(c.centre.size(), Eigen::Vector3d::Zero());
  c.total.assign(c.centre.size(), 0.0);
  for (std::size_t i = 0; i < position.size(); ++i) {
    sum[c.cluster[i]] += weight[i] * position[i];
    c.total[c.cluster[i]] += weight[i];
  }
  std::vector<std::size_t> kept(c.centre.size(), 0);
  std::size_t n = 0;
  for (std::size_t k = 0; k < c.centre.size(); ++k) {
    if (!(c.total[k] > 0.0)) continue;
    c.centre[n] = sum[k] / c.total[k];
    c.total[n] = c.total[k];
    kept[k] = n++;
  }
  c.centre.resize(n);
  c.total.resize(n);
  for (std::size_t& k : c.cluster) k = kept[k];
}

void lloyd(const Positions& position, const ClusterWeights& weight, Clusters& c) {
  for (int pass = 0; pass < max_passes; ++pass) {
    bool changed = pass == 0;
    for (std::size_t i = 0; i < position.size(); ++i) {
      const std::size_t k = closest(c.centre, position[i]);
      changed |= k != c.cluster[i];
      c.cluster[i] = k;
    }
    if (!changed) return;
    updateCentres(position, weight, c);
  }
}

/// Moves single samples to another cluster if that lowers the objective: taking a sample of weight w out
/// of a cluster of weight W gains w W / (W - w) d^2, putting it into one costs w W / (W + w) d^2.
bool exchange(const Positions& position, const ClusterWeights& weight, Clusters& c) {
  bool moved = false;
  for (std::size_t i = 0; i < position.size(); ++i) {
    const std::size_t from = c.cluster[i];
    const double w = weight[i];
    const double rest = c.total[from] - w;
    if (!(rest > 1e-9 * w)) continue;  // alone in its cluster
    const double gain = w * c.total[from] / rest * (position[i] - c.centre[from]).squaredNorm();
    std::size_t to = from;
    double cost = gain * (1.0 - 1e-9);  // rounding alone must not move a sample back and forth
    for (std::size_t k = 0; k < c.centre.size(); ++k) {
      if (k == from) continue;
      const double of_k = w * c.total[k] / (c.total[k] + w) * (position[i] - c.centre[k]).squaredNorm();
      if (of_k < cost) {
        cost = of_k;
        to = k;
      }
    }
    if (to == from) continue;
    c.centre[from] = (c.total[from] * c.centre[from] - w * position[i]) / rest;
    c.centre[to] = (c.total[to] * c.centre[to] + w * position[i]) / (c.total[to] + w);
    c.total[from] = rest;
    c.total[to] += w;
    c.cluster[i] = to;
    moved = true;
  }
  return moved;
}

void checkLengths(const std::vector<Eigen::Vector3d>& position, const std::vector<double>& weight) {
  if (position.size() != weight.size()) {
    throw std::invalid_argument("k-means: " + std::to_string(position.size()) + " positions and " +
                                std::to_string(weight.size()) + " weights; expected one of each per sample");
  }
}

}  // namespace

std::vector<Eigen::Vector3d> addSeeds(const std::vector<Eigen::Vector3d>& position,
                                      const std::vector<double>& weight, std::vector<Eigen::Vector3d> seeds,
                                      std::size_t count, double min_separation,
                                      const Eigen::Matrix3d& metric) {
  checkLengths(position, weight);
  if (position.empty()) return {};
  if (seeds.empty()) throw std::invalid_argument("k-means: no seed to start from, expected at least one");
  const auto mapped = static_cast<Eigen::Matrix3Xd>(
      metric * Eigen::Map<const Eigen::Matrix3Xd>(position.front().data(), 3,
                                                  static_cast<Eigen::Index>(position.size())));
  std::vector<double> distance(position.size(), std::numeric_limits<double>::infinity());
  std::size_t measured = 0;  // seeds that `distance` contains
  while (seeds.size() < count) {
    for (; measured < seeds.size(); ++measured) {
      const Eigen::Vector3d seed = metric * seeds[measured];
      for (std::size_t i = 0; i < position.size(); ++i) {
        distance[i] = std::min(distance[i], (mapped.col(static_cast<Eigen::Index>(i)) - seed).squaredNorm());
      }
    }
    std::size_t next = 0;
    double best = 0.0;
    for (std::size_t i = 0; i < position.size(); ++i) {
      if (distance[i] < min_separation * min_separation || !(weight[i] * distance[i] > best)) continue;
      best = weight[i] * distance[i];
      next = i;
    }
    if (!(best > 0.0)) break;
    seeds.push_back(position[next]);
  }
  return seeds;
}

Clustering refineClusters(const std::vector<Eigen::Vector3d>& position, const std::vector<double>& weight,
                          std::vector<Eigen::Vector3d> centre) {
  checkLengths(position, weight);
  if (position.empty()) return {};
  if (centre.empty()) throw std::invalid_argument("k-means: no centre to start from, expected at least one");
  Clusters c{std::vector<std::size_t>(position.size()), std::move(centre), {}};
  lloyd(position, weight, c);
  for (int pass = 0; pass < max_passes && exchange(position, weight, c); ++pass) lloyd(position, weight, c);
  Clustering result;
  for (std::size_t i = 0; i < position.size(); ++i)
    result.objective += weight[i] * (position[i] - c.centre[c.cluster[i]]).squaredNorm();
  result.centre = std::move(c.centre);
  result.cluster = std::move(c.cluster);
  return result;
}

Clustering weightedKMeans(const std::vector<Eigen::Vector3d>& position, const std::vector<double>& weight,
                          std::size_t count, double min_separation, std::size_t restarts,
                          const Eigen::Matrix3d& metric) {
  checkLengths(position, weight);
  Clustering best;
  if (position.empty() || count == 0) return best;
  // First seeds far from each other make the restarts differ.
  std::size_t first = 0;
  std::vector<double> distance(position.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 1; i < position.size(); ++i) {
    if (weight[i] > weight[first]) first = i;
  }
  for (std::size_t run = 0; run < std::max<std::size_t>(restarts, 1); ++run) {
    auto seeds = addSeeds(position, weight, {position[first]}, count, min_separation, metric);
    Clustering clustering = refineClusters(position, weight, std::move(seeds));
    if (best.centre.size() < clustering.centre.size() ||
        (best.centre.size() == clustering.centre.size() && clustering.objective < best.objective)) {
      best = std::move(clustering);
    }
    std::size_t farthest = first;
    double farthest_distance = 0.0;
    for (std::size_t i = 0; i < position.size(); ++i) {
      distance[i] = std::min(distance[i], (position[i] - position[first]).squaredNorm());
      if (distance[i] > farthest_distance) {
        farthest_distance = distance[i];
        farthest = i;
      }
    }
    if (!(farthest_distance > 0.0)) break;  // every sample has been a first seed
    first = farthest;
  }
  return best;
}

}  // namespace tactile_clay::ultrasound
