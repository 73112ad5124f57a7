#include "nodes/skin_paint.h"

#include <algorithm>
#include <limits>

#include "nodes/color_bar.h"

namespace tactile_clay::nodes {

using Eigen::Vector3f;

Vector3f skinColor() {
  return {0.89f, 0.70f, 0.58f};
}

Vector3f painted(float share, const Vector3f& skin) {
  const float blend = std::min(1.0f, share / (4.0f * touch_share));
  return (1.0f - blend) * skin + blend * pressureColor(share);
}

float closestSquare(const Vector3f& at, const std::vector<Vector3f>& places) {
  float closest = std::numeric_limits<float>::infinity();
  for (const Vector3f& place : places) closest = std::min(closest, (place - at).squaredNorm());
  return closest;
}

bool isNear(const Vector3f& at, const std::vector<Vector3f>& places, float reach) {
  return std::any_of(places.begin(), places.end(),
                     [&](const Vector3f& place) { return (place - at).squaredNorm() < reach * reach; });
}

}  // namespace tactile_clay::nodes
