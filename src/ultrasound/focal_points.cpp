#include "ultrasound/focal_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ultrasound/contact_clusters.h"
#include "ultrasound/skin_disc.h"
#include "ultrasound/skin_samples.h"
#include "values/range.h"

namespace tactile_clay::ultrasound {
namespace {

using contact::PressureSample;

double gaussian(double squared_distance, double sigma) {
  return std::exp(-squared_distance / (2.0 * sigma * sigma));
}

/// The centre of cluster k, or the skin beside it. If the centre is farther than sigma from all samples, the
/// closest sample.
Eigen::Vector3d onSkin(const ContactField& field, const Clustering& clustering, std::size_t k, double sigma) {
  double closest = std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  std::vector<SkinDisc> skin;
  for (std::size_t i = 0; i < field.position.size(); ++i) {
    if (clustering.cluster[i] != k) continue;
    skin.push_back(field.skin[i]);
    const double distance = (field.position[i] - clustering.centre[k]).squaredNorm();
    if (distance < closest) {
      closest = distance;
      nearest = i;
    }
  }
  return closest <= sigma * sigma ? ontoSkin(clustering.centre[k], skin) : field.position[nearest];
}

double fitPressure(const ContactField& field, const Clustering& clustering, std::size_t k,
                   const Eigen::Vector3d& at, const FocalPointConfig& config) {
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

}  // namespace

void FocalPointConfig::validate() const {
  using values::requireAbove;
  using values::requireAtLeast;
  using values::requireIn;
  requireAtLeast("focal points: max_points", static_cast<double>(max_points), 1.0);
  requireAtLeast("focal points: min_separation", min_separation, 0.0);
  requireAtLeast("focal points: field_samples", static_cast<double>(field_samples), 1.0);
  requireAtLeast("focal points: path_points", static_cast<double>(path_points), 1.0);
  requireAbove("focal points: path_spacing", path_spacing, 0.0);
  requireAtLeast("focal points: min_resolution", min_resolution, 0.0);
  requireAbove("focal points: sigma", sigma, 0.0);
  requireAbove("focal points: full_scale_pressure", full_scale_pressure, 0.0);
  requireIn("focal points: compression_knee", compression_knee, 0.0, 1.0);
  requireIn("focal points: side_lobe_floor", side_lobe_floor, 0.0, 1.0);
  requireAbove("focal points: felt_gain", felt_gain, 0.0);
  requireAtLeast("focal points: felt_threshold", felt_threshold, 0.0);
  requireAtLeast("focal points: minimum_pressure", minimum_pressure, 0.0);
  requireAtLeast("focal points: minimum_force", minimum_force, 0.0);
  requireAtLeast("focal points: follow_distance", follow_distance, 0.0);
}

FocalPointRenderer::FocalPointRenderer(const FocalPointConfig& config) {
  configure(config);
}

void FocalPointRenderer::configure(const FocalPointConfig& config) {
  config.validate();
  config_ = config;
}

void FocalPointRenderer::reset() {
  ids_ = {};
  report_ = {};
}

std::vector<FocalPoint> FocalPointRenderer::render(const std::vector<PressureSample>& samples) {
  report_ = {};
  if (isField(config_.modulation)) return this->field(samples);
  const ContactField field = contactField(samples, config_, report_.ignored_samples);
  if (config_.modulation == Modulation::spatiotemporal) {
    std::vector<FocalPoint> points = path(field.position, field.weight, field.pressure);
    finish(samples, points);
    ids_.forget();
    return points;
  }
  const Clustering clustering =
      contactClusters(field, config_, array_ ? &*array_ : nullptr, ids_.before(), report_.merged_points);

  std::vector<double> force(clustering.centre.size(), 0.0);
  for (std::size_t i = 0; i < field.position.size(); ++i) {
    force[clustering.cluster[i]] += field.pressure[i] * field.area[i];
  }
  std::vector<FocalPoint> points;
  for (std::size_t k = 0; k < clustering.centre.size(); ++k) {
    if (force[k] < config_.minimum_force) continue;
    FocalPoint point;
    point.position = onSkin(field, clustering, k, config_.sigma);
    point.pressure = fitPressure(field, clustering, k, point.position, config_);
    points.push_back(point);
  }
  // Sorted by place, so that new ids do not depend on which seed found a point.
  std::sort(points.begin(), points.end(), [](const FocalPoint& a, const FocalPoint& b) {
    return std::lexicographical_compare(a.position.begin(), a.position.end(), b.position.begin(),
                                        b.position.end());
  });
  ids_.assign(points, config_.follow_distance);
  finish(samples, points);
  return points;
}

std::vector<FocalPoint> FocalPointRenderer::field(const std::vector<PressureSample>& samples) {
  ids_.forget();
  std::vector<PressureSample> skin;
  double force = 0.0;
  for (const PressureSample& sample : samples) {
    if (!usable(sample) || !(sample.pressure >= 0.0f) || !sample.normal.allFinite()) {
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
    if (config_.field_normals) point.normal = sample.normal;
    if (config_.field_weights) point.weight = sample.weight;
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
