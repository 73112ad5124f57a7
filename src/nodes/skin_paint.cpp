#include "nodes/skin_paint.h"

#include <algorithm>

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

bool isNear(const Vector3f& at, const std::vector<Vector3f>& places, float reach) {
  return std::any_of(places.begin(), places.end(),
                     [&](const Vector3f& place) { return (place - at).squaredNorm() < reach * reach; });
}

}  // namespace tactile_clay::nodes
