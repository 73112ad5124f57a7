#include "rviz_plugins/shown_points.h"

#include <algorithm>
#include <cmath>

#include "ultrasound/modulation.h"

namespace tactile_clay::rviz_plugins {
namespace {

// m, of a focus 0.2 m above the array, at half of its amplitude (doc/method/rendering.md). The array cannot
// show two maxima that are closer together.
constexpr double focus_width = 0.014;

double squaredDistance(const geometry_msgs::Point& a, const geometry_msgs::Point& b) {
  const double x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z;
}

}  // namespace

std::vector<tactile_clay::FocalPoint> shownPoints(const tactile_clay::FocalPointArray& message) {
  const bool field = ultrasound::isField(static_cast<ultrasound::Modulation>(message.modulation));
  std::vector<tactile_clay::FocalPoint> candidates;
  for (const tactile_clay::FocalPoint& point : message.points) {
    const geometry_msgs::Point& at = point.position;
    const auto intensity = static_cast<double>(point.intensity),
               pressure = static_cast<double>(point.pressure);
    if (!std::isfinite(at.x + at.y + at.z + intensity + pressure)) continue;
    if (!field || pressure > 0.0) candidates.push_back(point);
  }
  if (!field) return candidates;
  // The strongest first, so that of two neighbours with the same pressure only the first is shown.
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.pressure > b.pressure; });
  std::vector<tactile_clay::FocalPoint> shown;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const auto above = candidates.begin() + static_cast<std::ptrdiff_t>(k);
    const bool covered = std::any_of(candidates.begin(), above, [&](const auto& other) {
      return squaredDistance(other.position, candidates[k].position) < focus_width * focus_width;
    });
    if (!covered) shown.push_back(candidates[k]);
  }
  return shown;
}

}  // namespace tactile_clay::rviz_plugins
