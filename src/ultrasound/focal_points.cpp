#include "ultrasound/focal_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

#include "ultrasound/felt_force.h"
#include "ultrasound/skin_disc.h"
#include "ultrasound/skin_samples.h"
#include "ultrasound/weighted_k_means.h"

namespace tactile_clay::ultrasound {
namespace {

using contact::PressureSample;

constexpr std::size_t restarts = 4;  // of the first clustering; more buy little on a hand. Then one a frame
const Eigen::Vector3d reference_point(0.0, 0.0, 0.2);  // m, where a hand is
constexpr double warm_start_slack = 0.05;  // share of the objective given up for points that stay in place

/// Samples worth rendering, as clustering needs them.
struct Field {
  std::vector<Eigen::Vector3d> position;
  std::vector<double> weight;  // alpha p* A
  std::vector<double> pressure;
  std::vector<double> area;
  std::vector<SkinDisc> skin;
};

bool usable(const PressureSample& s) {
  return s.position.allFinite() && std::isfinite(s.pressure) && std::isfinite(s.area) && s.area > 0.0f &&
         std::isfinite(s.weight) && s.weight > 0.0f;
}

Field gather(const std::vector<PressureSample>& samples, const FocalPointConfig& config,
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

  Field field;
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

/// How close two points may be: apart by `distance`, m, and for the array, if there is one, by `separation`.
struct Spacing {
  double distance;
  double separation;
  const ArrayReach* array;
};

/// Map of space in which points 1 apart are as close as they may be. The array's part is that at `centre`.
Eigen::Matrix3d seedMetric(const Spacing& least, const Eigen::Vector3d& centre) {
  const double k = least.array->acoustics().wavenumber();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> beam(least.array->beam(centre).spread.cast<double>() *
                                                            std::pow(k / least.separation, 2));
  Eigen::Vector3d over_length = beam.eigenvalues().cwiseMax(1e-6).cwiseSqrt();
  if (least.distance > 0.0) over_length = over_length.cwiseMin(1.0 / least.distance);
  return over_length.asDiagonal() * beam.eigenvectors().transpose();
}

/// How far two centres are apart, over the least that they may be.
double clearance(const Eigen::Vector3d& way, const FocusBeam& a, const FocusBeam& b, const Spacing& least) {
  double clear = std::numeric_limits<double>::infinity();
  if (least.distance > 0.0) clear = way.norm() / least.distance;
  if (least.array != nullptr && least.separation > 0.0)
    clear = std::min(clear, separation(way, a, b, least.array->acoustics().wavenumber()) / least.separation);
  return clear;
}

/// Merges the closest two centres until all are far enough apart, and clusters anew, until they stay so.
/// \param unresolved counts the pairs that only the array is too coarse for
Clustering separate(const Field& field, Clustering clustering, const Spacing& least,
                    std::size_t& unresolved) {
  while (clustering.center.size() > 1) {
    std::vector<Eigen::Vector3d> center = clustering.center;
    std::vector<double> weight(center.size(), 0.0);
    for (std::size_t i = 0; i < field.weight.size(); ++i) weight[clustering.cluster[i]] += field.weight[i];
    std::vector<FocusBeam> beam(center.size());
    const auto look = [&](std::size_t k) {
      if (least.array != nullptr && least.separation > 0.0) beam[k] = least.array->beam(center[k]);
    };
    for (std::size_t k = 0; k < center.size(); ++k) look(k);
    while (center.size() > 1) {
      std::size_t a = 0;
      std::size_t b = 0;
      double closest = 1.0;
      for (std::size_t i = 0; i < center.size(); ++i) {
        for (std::size_t j = i + 1; j < center.size(); ++j) {
          const double clear = clearance(center[j] - center[i], beam[i], beam[j], least);
          if (clear < closest) {
            closest = clear;
            a = i;
            b = j;
          }
        }
      }
      if (a == b) break;
      if ((center[a] - center[b]).norm() >= least.distance) ++unresolved;
      center[a] = (weight[a] * center[a] + weight[b] * center[b]) / (weight[a] + weight[b]);
      weight[a] += weight[b];
      look(a);
      const auto at = static_cast<std::ptrdiff_t>(b);
      center.erase(center.begin() + at);
      weight.erase(weight.begin() + at);
      beam.erase(beam.begin() + at);
    }
    if (center.size() == clustering.center.size()) break;
    clustering = refineClusters(field.position, field.weight, std::move(center));
  }
  return clustering;
}

std::size_t heaviest(const Field& field) {
  return static_cast<std::size_t>(std::max_element(field.weight.begin(), field.weight.end()) -
                                  field.weight.begin());
}

/// \param unresolved how many points there would be more if the array could tell them apart
Clustering cluster(const Field& field, const FocalPointConfig& config, const ArrayReach* array,
                   const std::vector<FocalPoint>& previous, std::size_t& unresolved) {
  const Spacing least{config.min_separation, config.min_resolution, array};
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
    metric = seedMetric(least, centre / total);
    apart = 1.0;
    on_skin = addSeeds(field.position, field.weight, {field.position[heaviest(field)]}, config.max_points,
                       config.min_separation)
                  .size();
  }
  Clustering cold = weightedKMeans(field.position, field.weight, config.max_points, apart,
                                   previous.empty() ? restarts : 1, metric);
  const std::size_t unseeded = on_skin - std::min(on_skin, cold.center.size());  // room on the skin only
  cold = separate(field, std::move(cold), least, unresolved);
  unresolved += unseeded;
  if (previous.empty() || previous.size() > config.max_points) return cold;

  std::vector<Eigen::Vector3d> start;
  start.reserve(previous.size());
  for (const FocalPoint& point : previous) start.push_back(point.position);
  start = addSeeds(field.position, field.weight, std::move(start), config.max_points, apart, metric);
  Clustering warm = refineClusters(field.position, field.weight, std::move(start));
  std::size_t unresolved_warm = unseeded;
  warm = separate(field, std::move(warm), least, unresolved_warm);
  if (warm.objective > (1.0 + warm_start_slack) * cold.objective) return cold;
  unresolved = unresolved_warm;
  return warm;
}

double gaussian(double squared_distance, double sigma) {
  return std::exp(-squared_distance / (2.0 * sigma * sigma));
}

/// The centre of cluster k, or the skin beside it; the closest sample where the centre is farther than sigma
/// from all.
Eigen::Vector3d onSkin(const Field& field, const Clustering& clustering, std::size_t k, double sigma) {
  double closest = std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  std::vector<SkinDisc> skin;
  for (std::size_t i = 0; i < field.position.size(); ++i) {
    if (clustering.cluster[i] != k) continue;
    skin.push_back(field.skin[i]);
    const double distance = (field.position[i] - clustering.center[k]).squaredNorm();
    if (distance < closest) {
      closest = distance;
      nearest = i;
    }
  }
  return closest <= sigma * sigma ? ontoSkin(clustering.center[k], skin) : field.position[nearest];
}

double fitPressure(const Field& field, const Clustering& clustering, std::size_t k, const Eigen::Vector3d& at,
                   const FocalPointConfig& config) {
  double target = 0.0;
  double model = 0.0;
  for (std::size_t i = 0; i < field.position.size(); ++i) {
    if (clustering.cluster[i] != k) continue;
    const double g = gaussian((field.position[i] - at).squaredNorm(), config.sigma);
    target += field.area[i] * field.pressure[i] * g;
    model += field.area[i] * (config.fit == IntensityFit::least_squares ? g * g : g);
  }
  return target / model;  // the closest sample is within sigma: model > 0
}

void requireRange(const char* name, double value, double low, bool low_included) {
  if (std::isfinite(value) && (value > low || (low_included && value == low))) return;
  throw std::invalid_argument("focal points: " + std::string(name) + " is " + std::to_string(value) +
                              ", expected a finite number " + (low_included ? "not below " : "above ") +
                              std::to_string(low));
}

}  // namespace

double compress(double share, double knee) {
  if (share <= knee) return share;
  if (knee >= 1.0) return 1.0;
  return knee + (1.0 - knee) * (1.0 - std::exp(-(share - knee) / (1.0 - knee)));
}

void FocalPointConfig::validate() const {
  if (max_points < 1) throw std::invalid_argument("focal points: max_points is 0, expected at least 1");
  requireRange("min_separation", min_separation, 0.0, true);
  if (field_samples < 1) throw std::invalid_argument("focal points: field_samples is 0, expected at least 1");
  if (path_points < 1) throw std::invalid_argument("focal points: path_points is 0, expected at least 1");
  requireRange("path_spacing", path_spacing, 0.0, false);
  requireRange("min_resolution", min_resolution, 0.0, true);
  requireRange("sigma", sigma, 0.0, false);
  requireRange("full_scale_pressure", full_scale_pressure, 0.0, false);
  if (!(compression_knee >= 0.0 && compression_knee <= 1.0)) {
    throw std::invalid_argument("focal points: compression_knee is " + std::to_string(compression_knee) +
                                ", expected 0 to 1");
  }
  if (!(side_lobe_floor >= 0.0 && side_lobe_floor <= 1.0)) {
    throw std::invalid_argument("focal points: side_lobe_floor is " + std::to_string(side_lobe_floor) +
                                ", expected 0 to 1");
  }
  requireRange("minimum_pressure", minimum_pressure, 0.0, true);
  requireRange("minimum_force", minimum_force, 0.0, true);
  requireRange("follow_distance", follow_distance, 0.0, true);
}

FocalPointRenderer::FocalPointRenderer(const FocalPointConfig& config) {
  configure(config);
}

void FocalPointRenderer::configure(const FocalPointConfig& config) {
  config.validate();
  config_ = config;
}

void FocalPointRenderer::reset() {
  previous_.clear();
  report_ = {};
  next_id_ = 0;
}

std::vector<FocalPoint> FocalPointRenderer::render(const std::vector<PressureSample>& samples) {
  report_ = {};
  if (config_.modulation == Modulation::field) return this->field(samples);
  const Field field = gather(samples, config_, report_.ignored_samples);
  if (config_.modulation == Modulation::spatiotemporal) {
    std::vector<FocalPoint> points = path(field.position, field.weight, field.pressure);
    finish(samples, points);
    previous_.clear();
    return points;
  }
  const Clustering clustering =
      cluster(field, config_, array_ ? &*array_ : nullptr, previous_, report_.merged_points);

  std::vector<double> force(clustering.center.size(), 0.0);
  for (std::size_t i = 0; i < field.position.size(); ++i) {
    force[clustering.cluster[i]] += field.pressure[i] * field.area[i];
  }
  std::vector<FocalPoint> points;
  for (std::size_t k = 0; k < clustering.center.size(); ++k) {
    if (force[k] < config_.minimum_force) continue;
    FocalPoint point;
    point.position = onSkin(field, clustering, k, config_.sigma);
    point.pressure = fitPressure(field, clustering, k, point.position, config_);
    points.push_back(point);
  }
  // By place, so that new ids do not depend on which seed found a point.
  std::sort(points.begin(), points.end(), [](const FocalPoint& a, const FocalPoint& b) {
    return std::lexicographical_compare(a.position.begin(), a.position.end(), b.position.begin(),
                                        b.position.end());
  });
  assignIds(points);
  finish(samples, points);
  previous_ = points;
  return points;
}

std::vector<FocalPoint> FocalPointRenderer::field(const std::vector<PressureSample>& samples) {
  previous_.clear();
  std::vector<PressureSample> skin;
  double force = 0.0;
  for (const PressureSample& sample : samples) {
    if (!usable(sample) || !(sample.pressure >= 0.0f)) {
      ++report_.ignored_samples;
      continue;
    }
    skin.push_back(sample);
    if (skin.back().pressure < config_.minimum_pressure) skin.back().pressure = 0.0f;
    force += static_cast<double>(skin.back().pressure) * skin.back().area;
  }
  std::vector<FocalPoint> points;
  if (force < config_.minimum_force) return points;
  for (const SkinSample& sample : skinSamples(skin, config_.field_samples)) {
    FocalPoint point;
    point.id = static_cast<std::uint32_t>(points.size());
    point.position = sample.position;
    point.pressure = sample.pressure;
    points.push_back(point);
    report_.area.push_back(sample.area);
  }
  setIntensities(points);
  return points;
}

std::vector<FocalPoint> FocalPointRenderer::path(const std::vector<Eigen::Vector3d>& position,
                                                 const std::vector<double>& weight,
                                                 const std::vector<double>& pressure) const {
  const std::vector<PathPoint> places =
      samplePath(position, weight, pressure, config_.path_spacing, config_.path_points);
  std::vector<Eigen::Vector3d> at;
  for (const PathPoint& place : places) at.push_back(place.position);
  std::vector<FocalPoint> points;
  for (const std::size_t k : tour(at)) {
    FocalPoint point;
    point.id = static_cast<std::uint32_t>(points.size());
    point.position = places[k].position;
    point.pressure = places[k].pressure;
    points.push_back(point);
  }
  return points;
}

void FocalPointRenderer::finish(const std::vector<PressureSample>& samples, std::vector<FocalPoint>& points) {
  setIntensities(points);
  report_.error = reconstructionError(samples, points, config_.sigma);
  report_.weighted_error = reconstructionError(samples, points, config_.sigma, true);
}

void FocalPointRenderer::setArray(const ArrayReach& array) {
  array_ = array;
  reference_ = array.amplitude(reference_point);
  if (!(reference_ > 0.0)) {
    throw std::invalid_argument("focal points: the array gives nothing 0.2 m above its centre");
  }
}

void FocalPointRenderer::setIntensities(std::vector<FocalPoint>& points) {
  const bool field = config_.modulation == Modulation::field;
  const double count = field ? 1.0 : static_cast<double>(points.size());
  if (array_) report_.gain = radiationPressure(array_->acoustics(), reference_) / config_.full_scale_pressure;
  std::vector<double> limit;  // Pa on the skin
  double strongest = 0.0;     // of what is granted, Pa
  for (FocalPoint& point : points) {
    double share = point.pressure / config_.full_scale_pressure;
    limit.push_back(0.0);
    if (array_) {
      limit.back() = radiationPressure(array_->acoustics(), array_->amplitude(point.position)) / count;
      share = limit.back() > 0.0 ? report_.gain * point.pressure / limit.back()
                                 : std::numeric_limits<double>::infinity();
    }
    const bool reachable = !array_ || limit.back() > 0.0;  // not behind the array
    const double given = reachable ? compress(share, config_.compression_knee) : 0.0;
    if (share > config_.compression_knee) ++report_.compressed_points;
    if (share > 1.0) ++report_.saturated_points;
    point.intensity = std::sqrt(given);
    report_.wanted.push_back(report_.gain * point.pressure);
    report_.granted.push_back(given * limit.back());
    if (array_ && !field) report_.area.push_back(spotArea(array_->acoustics(), array_->beam(point.position)));
    strongest = std::max(strongest, report_.granted.back());
  }
  // One focus at a time has no neighbours, and in a field what is weak is meant to be so.
  if (field || config_.modulation == Modulation::spatiotemporal) return;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double least = config_.side_lobe_floor * config_.side_lobe_floor * strongest;
    if (!(limit[k] > 0.0) || report_.granted[k] >= least) continue;
    report_.granted[k] = std::min(least, limit[k]);
    points[k].intensity = std::sqrt(report_.granted[k] / limit[k]);
    ++report_.raised_points;
  }
}

void FocalPointRenderer::assignIds(std::vector<FocalPoint>& points) {
  struct Pair {
    double distance;
    std::size_t before;  // index into previous_, which is sorted by id
    std::size_t now;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < previous_.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double distance = (previous_[i].position - points[j].position).norm();
      if (distance <= config_.follow_distance) pairs.push_back({distance, i, j});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance, a.before, a.now) < std::tie(b.distance, b.before, b.now);
  });

  std::vector<bool> taken(previous_.size(), false);
  std::vector<bool> named(points.size(), false);
  for (const Pair& pair : pairs) {
    if (taken[pair.before] || named[pair.now]) continue;
    taken[pair.before] = true;
    named[pair.now] = true;
    points[pair.now].id = previous_[pair.before].id;
  }
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (!named[j]) points[j].id = next_id_++;
  }
  std::sort(points.begin(), points.end(),
            [](const FocalPoint& a, const FocalPoint& b) { return a.id < b.id; });
}

double reconstructionError(const std::vector<PressureSample>& samples, const std::vector<FocalPoint>& points,
                           double sigma, bool weighted) {
  double error = 0.0;
  double total = 0.0;
  for (const PressureSample& s : samples) {
    if (!usable(s)) continue;
    double closest = std::numeric_limits<double>::infinity();
    double rendered = 0.0;
    for (const FocalPoint& point : points) {
      const double distance = (point.position - s.position.cast<double>()).squaredNorm();
      if (distance >= closest) continue;
      closest = distance;
      rendered = point.pressure * gaussian(distance, sigma);
    }
    const double w = weighted ? static_cast<double>(s.area) * s.weight : s.area;
    error += w * (rendered - s.pressure) * (rendered - s.pressure);
    total += w * s.pressure * s.pressure;
  }
  return total > 0.0 ? std::sqrt(error / total) : 0.0;
}

}  // namespace tactile_clay::ultrasound
