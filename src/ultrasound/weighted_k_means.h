#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace tactile_clay::ultrasound {

struct Clustering {
  std::vector<Eigen::Vector3d> centre;  // weighted mean of each cluster, m
  std::vector<std::size_t> cluster;     // of each sample
  double objective = 0.0;               // Eq. 8: sum of w |x - centre|^2
};

/// Adds samples to the `seeds` given, deterministically: each time the sample with the largest w d^2, where d
/// is its distance to the closest seed so far. Only samples at least `min_separation` (m) away from every
/// seed are taken, so there may be fewer than `count` in the end. The lower index wins a tie.
/// @param metric distances are those of metric x, and `min_separation` is in its unit
/// @throws std::invalid_argument if the arrays differ in length or, with samples, no seed is given
std::vector<Eigen::Vector3d> addSeeds(const std::vector<Eigen::Vector3d>& position,
                                      const std::vector<double>& weight, std::vector<Eigen::Vector3d> seeds,
                                      std::size_t count, double min_separation,
                                      const Eigen::Matrix3d& metric = Eigen::Matrix3d::Identity());

/// Local optimum of Eq. 8 from the given centres: Lloyd's iteration until no sample changes its cluster, then
/// single exchanges (Hartigan & Wong 1979) that lower the objective further, and so on. A centre that loses
/// all its samples is removed, so there may be fewer clusters than centres given.
/// @param position of the samples, m, finite
/// @param weight of each, positive and finite
/// @throws std::invalid_argument if the arrays differ in length or, with samples, no centre is given
Clustering refineClusters(const std::vector<Eigen::Vector3d>& position, const std::vector<double>& weight,
                          std::vector<Eigen::Vector3d> centre);

/// Weighted k-means (Eq. 8) of at most `count` clusters: the best of `restarts` refinements, seeded by
/// addSeeds from the heaviest sample, then from the samples farthest from the ones used before.
/// Deterministic; ties go to the lower index.
/// @param metric of the seeds, as addSeeds
Clustering weightedKMeans(const std::vector<Eigen::Vector3d>& position, const std::vector<double>& weight,
                          std::size_t count, double min_separation = 0.0, std::size_t restarts = 8,
                          const Eigen::Matrix3d& metric = Eigen::Matrix3d::Identity());

}  // namespace tactile_clay::ultrasound
