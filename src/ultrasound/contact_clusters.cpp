#include "ultrasound/contact_clusters.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace tactile_clay::ultrasound {

using contact::PressureSample;

namespace {

constexpr std::size_t restarts = 4;  // of the first clustering; more buy little on a hand. Then one a frame
constexpr double warm_start_slack = 0.05;  // share of the objective given up for points that stay in place

/// How close two points may be: apart by `distance`, m, and for the array, if there is one, by `separation`.
struct Spacing {
  double distance;
  double separation;
  const ArrayReach* array;
};

/// Map of space in which points 1 apart are as close as they may be. The array's part is that at `centre`.
Eigen::Matrix3d seedMetric(const Spacing& minimum, const Eigen::Vector3d& centre) {
  const double k = minimum.array->acoustics().wavenumber();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> beam(
      minimum.array->beam(centre).spread.cast<double>() * std::pow(k / minimum.separation, 2));
  Eigen::Vector3d over_length = beam.eigenvalues().cwiseMax(1e-6).cwiseSqrt();
  if (minimum.distance > 0.0) over_length = over_length.cwiseMin(1.0 / minimum.distance);
  return over_length.asDiagonal() * beam.eigenvectors().transpose();
}

/// How far two centres are apart, over the minimum that they may be.
double clearance(const Eigen::Vector3d& way, const FocusBeam& a, const FocusBeam& b, const Spacing& minimum) {
  double clear = std::numeric_limits<double>::infinity();
  if (minimum.distance > 0.0) clear = way.norm() / minimum.distance;
  if (minimum.array != nullptr && minimum.separation > 0.0)
    clear =
        std::min(clear, separation(way, a, b, minimum.array->acoustics().wavenumber()) / minimum.separation);
  return clear;
}

/// Merges the closest two centres until all are far enough apart, and clusters anew, until they stay so.
/// @param unresolved counts the pairs that only the array is too coarse for
Clustering separate(const ContactField& field, Clustering clustering, const Spacing& minimum,
                    std::size_t& unresolved) {
  while (clustering.centre.size() > 1) {
    std::vector<Eigen::Vector3d> centre = clustering.centre;
    std::vector<double> weight(centre.size(), 0.0);
    for (std::size_t i = 0; i < field.weight.size(); ++i) weight[clustering.cluster[i]] += field.weight[i];
    std::vector<FocusBeam> beam(centre.size());
    const auto look = [&](std::size_t k) {
      if (minimum.array != nullptr && minimum.separation > 0.0) beam[k] = minimum.array->beam(centre[k]);
    };
    for (std::size_t k = 0; k < centre.size(); ++k) look(k);
    while (centre.size() > 1) {
      std::size_t a = 0;
      std::size_t b = 0;
      double closest = 1.0;
      for (std::size_t i = 0; i < centre.size(); ++i) {
        for (std::size_t j = i + 1; j < centre.size(); ++j) {
          const double clear = clearance(centre[j] - centre[i], beam[i], beam[j], minimum);
          if (clear < closest) {
            closest = clear;
            a = i;
            b = j;
          }
        }
      }
      if (a == b) break;
      if ((centre[a] - centre[b]).norm() >= minimum.distance) ++unresolved;
      centre[a] = (weight[a] * centre[a] + weight[b] * centre[b]) / (weight[a] + weight[b]);
      weight[a] += weight[b];
      look(a);
      const auto at = static_cast<std::ptrdiff_t>(b);
      centre.erase(centre.begin() + at);
      weight.erase(weight.begin() + at);
      beam.erase(beam.begin() + at);
    }
    if (centre.size() == clustering.centre.size()) break;
    clustering = refineClusters(field.position, field.weight, std::move(centre));
  }
  return clustering;
}

std::size_t heaviest(const ContactField& field) {
  return static_cast<std::size_t>(std::max_element(field.weight.begin(), field.weight.end()) -
                                  field.weight.begin());
}

}  // namespace

bool usable(const PressureSample& s) {
  return s.position.allFinite() && std::isfinite(s.pressure) && std::isfinite(s.area) && s.area > 0.0f &&
         std::isfinite(s.weight) && s.weight > 0.0f;
}

ContactField contactField(const std::vector<PressureSample>& samples, const FocalPointConfig& config,
                          std::size_t& ignored) {
  std::vector<PressureSample> kept;
  kept.reserve(samples.size());
  ignored = 0;
  for (const PressureSample& s : samples) {
    if (!usable(s)) {
      ++ignored;
    } else if (s.pressure > 0.0f && s.pressure >= config.minimum_pressure) {
      kept.push_back(s);
    }
  }
  // One order for every permutation of the samples: sums and ties come out the same.
  const auto key = [](const PressureSample& s) {
    return std::make_tuple(s.position.x(), s.position.y(), s.position.z(), s.pressure, s.area, s.weight);
  };
  std::sort(kept.begin(), kept.end(),
            [&key](const PressureSample& a, const PressureSample& b) { return key(a) < key(b); });

  ContactField field;
  for (const PressureSample& s : kept) {
    const double alpha = config.perceptual_weights ? s.weight : 1.0;
    field.position.emplace_back(s.position.cast<double>());
    field.weight.push_back(alpha * s.pressure * s.area);
    field.pressure.push_back(s.pressure);
    field.area.push_back(s.area);
    field.skin.push_back(skinDisc(s));
  }
  return field;
}

Clustering contactClusters(const ContactField& field, const FocalPointConfig& config, const ArrayReach* array,
                           const std::vector<FocalPoint>& previous, std::size_t& unresolved) {
  const Spacing minimum{config.min_separation, config.min_resolution, array};
  unresolved = 0;
  Eigen::Matrix3d metric = Eigen::Matrix3d::Identity();
  double apart = config.min_separation;
  std::size_t on_skin = 0;  // points that there is room for there
  if (array != nullptr && config.min_resolution > 0.0 && !field.position.empty()) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double total = 0.0;
    for (std::size_t i = 0; i < field.position.size(); ++i) {
      centre += field.weight[i] * field.position[i];
      total += field.weight[i];
    }
    metric = seedMetric(minimum, centre / total);
    apart = 1.0;
    on_skin = addSeeds(field.position, field.weight, {field.position[heaviest(field)]}, config.max_points,
                       config.min_separation)
                  .size();
  }
  Clustering cold = weightedKMeans(field.position, field.weight, config.max_points, apart,
                                   previous.empty() ? restarts : 1, metric);
  const std::size_t unseeded = on_skin - std::min(on_skin, cold.centre.size());  // room on the skin only
  cold = separate(field, std::move(cold), minimum, unresolved);
  unresolved += unseeded;
  if (previous.empty() || previous.size() > config.max_points) return cold;

  std::vector<Eigen::Vector3d> start;
  start.reserve(previous.size());
  for (const FocalPoint& point : previous) start.push_back(point.position);
  start = addSeeds(field.position, field.weight, std::move(start), config.max_points, apart, metric);
  Clustering warm = refineClusters(field.position, field.weight, std::move(start));
  std::size_t unresolved_warm = unseeded;
  warm = separate(field, std::move(warm), minimum, unresolved_warm);
  if (warm.objective > (1.0 + warm_start_slack) * cold.objective) return cold;
  unresolved = unresolved_warm;
  return warm;
}

}  // namespace tactile_clay::ultrasound
