#include "ultrasound/weighted_k_means.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

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

/// Clusters with their weights, so that single exchanges know what they gain.
class Refinement {
 public:
  Refinement(const std::vector<Eigen::Vector3d>& position, const std::vector<double>& weight,
             std::vector<Eigen::Vector3d> centre)
      : position_(position), weight_(weight), cluster_(position.size()), center_(std::move(centre)) {}

  Clustering run() {
    lloyd();
    for (int pass = 0; pass < max_passes && exchange(); ++pass) lloyd();
    Clustering result;
    for (std::size_t i = 0; i < position_.size(); ++i) {
      result.objective += weight_[i] * (position_[i] - center_[cluster_[i]]).squaredNorm();
    }
    result.centre = std::move(center_);
    result.cluster = std::move(cluster_);
    return result;
  }

 private:
  void lloyd() {
    for (int pass = 0; pass < max_passes; ++pass) {
      bool changed = pass == 0;
      for (std::size_t i = 0; i < position_.size(); ++i) {
        const std::size_t k = closest(center_, position_[i]);
        changed |= k != cluster_[i];
        cluster_[i] = k;
      }
      if (!changed) return;
      updateCenters();
    }
  }

  void updateCenters() {
    std::vector<Eigen::Vector3d> sum(center_.size(), Eigen::Vector3d::Zero());
    total_.assign(center_.size(), 0.0);
    for (std::size_t i = 0; i < position_.size(); ++i) {
      sum[cluster_[i]] += weight_[i] * position_[i];
      total_[cluster_[i]] += weight_[i];
    }
    std::vector<std::size_t> kept(center_.size(), 0);
    std::size_t n = 0;
    for (std::size_t k = 0; k < center_.size(); ++k) {
      if (!(total_[k] > 0.0)) continue;
      center_[n] = sum[k] / total_[k];
      total_[n] = total_[k];
      kept[k] = n++;
    }
    center_.resize(n);
    total_.resize(n);
    for (std::size_t& k : cluster_) k = kept[k];
  }

  /// Moves single samples to another cluster where that lowers the objective: taking a sample of weight w out
  /// of a cluster of weight W gains w W / (W - w) d^2, putting it into one costs w W / (W + w) d^2.
  bool exchange() {
    bool moved = false;
    for (std::size_t i = 0; i < position_.size(); ++i) {
      const std::size_t from = cluster_[i];
      const double w = weight_[i];
      const double rest = total_[from] - w;
      if (!(rest > 1e-9 * w)) continue;  // alone in its cluster
      const double gain = w * total_[from] / rest * (position_[i] - center_[from]).squaredNorm();
      std::size_t to = from;
      double cost = gain * (1.0 - 1e-9);  // rounding alone must not move a sample back and forth
      for (std::size_t k = 0; k < center_.size(); ++k) {
        if (k == from) continue;
        const double c = w * total_[k] / (total_[k] + w) * (position_[i] - center_[k]).squaredNorm();
        if (c < cost) {
          cost = c;
          to = k;
        }
      }
      if (to == from) continue;
      center_[from] = (total_[from] * center_[from] - w * position_[i]) / rest;
      center_[to] = (total_[to] * center_[to] + w * position_[i]) / (total_[to] + w);
      total_[from] = rest;
      total_[to] += w;
      cluster_[i] = to;
      moved = true;
    }
    return moved;
  }

  const std::vector<Eigen::Vector3d>& position_;
  const std::vector<double>& weight_;
  std::vector<std::size_t> cluster_;
  std::vector<Eigen::Vector3d> center_;
  std::vector<double> total_;  // weight of each cluster
};

void checkLengths(const std::vector<Eigen::Vector3d>& position, const std::vector<double>& weight) {
  if (position.size() != weight.size()) {
    throw std::invalid_argument("k-means: " + std::to_string(position.size()) + " positions and " +
                                std::to_string(weight.size()) + " weights; expected one of each a sample");
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
  std::size_t measured = 0;  // seeds that `distance` knows
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
  return Refinement(position, weight, std::move(centre)).run();
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
