// How strong focal points are: FocalPointRenderer::setIntensities.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "ultrasound/felt_force.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::ultrasound {
namespace {

const Eigen::Vector3d reference_point(0.0, 0.0, 0.2);  // m, where a hand is

}  // namespace

double compress(double share, double knee) {
  if (share <= knee) return share;
  if (knee >= 1.0) return 1.0;
  return knee + (1.0 - knee) * (1.0 - std::exp(-(share - knee) / (1.0 - knee)));
}

void FocalPointRenderer::setArray(const ArrayReach& array) {
  array_ = array;
  reference_ = array.amplitude(reference_point);
  if (!(reference_ > 0.0)) {
    throw std::invalid_argument("focal points: the array gives nothing 0.2 m above its centre");
  }
}

void FocalPointRenderer::setIntensities(std::vector<FocalPoint>& points) {
  const bool field = isField(config_.modulation);
  const double count = field ? 1.0 : static_cast<double>(points.size());
  if (array_) report_.gain = radiationPressure(array_->acoustics(), reference_) / config_.full_scale_pressure;
  report_.gain *= config_.felt_gain;
  std::vector<double> limit;  // Pa on the skin
  double strongest = 0.0;     // granted pressure of all points, Pa
  for (FocalPoint& point : points) {
    double share = config_.felt_gain * point.pressure / config_.full_scale_pressure;
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
  raiseWeak(limit, strongest, points);
}

/// Raises points that are weaker than the side lobes of others, or that the person does not feel.
void FocalPointRenderer::raiseWeak(const std::vector<double>& limit, double strongest,
                                   std::vector<FocalPoint>& points) {
  // In stm a focus is alone at each time. In a field a weak place is meant to be weak.
  if (isField(config_.modulation) || config_.modulation == Modulation::spatiotemporal) return;
  for (std::size_t k = 0; k < points.size(); ++k) {
    double minimum = config_.side_lobe_floor * config_.side_lobe_floor * strongest;
    if (array_ && report_.area[k] > 0.0)
      minimum = std::max(minimum, config_.felt_threshold / report_.area[k]);
    if (!(limit[k] > 0.0) || report_.granted[k] >= minimum) continue;
    report_.granted[k] = std::min(minimum, limit[k]);
    points[k].intensity = std::sqrt(report_.granted[k] / limit[k]);
    ++report_.raised_points;
  }
}

}  // namespace tactile_clay::ultrasound
