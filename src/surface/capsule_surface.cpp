#include "surface/capsule_surface.h"

#include <algorithm>
#include <cmath>

#include "surface/marching_cubes.h"

namespace tactile_clay::surface {
namespace {

constexpr float reach = 0.004f;  // m, distance from a capsule at which its kernel ends
constexpr float level = 0.5f;
constexpr double farthest_centre = 1000.0;  // m, from the origin

/// A capsule as numbers for lanes. If one of its spheres contains the other, it is that sphere.
struct Cone {
  Eigen::Vector3f from, axis;         // m; unit
  float length, radius, slope, lean;  // m, m; slope of the radius, and lean of the normals, along the axis
};

Cone coneOf(const hand::Capsule& capsule) {
  const double taper = capsule.taper();
  if (taper >= 1.0)
    return {capsule.from.cast<float>(),
            Eigen::Vector3f::UnitZ(),
            0.0f,
            static_cast<float>(capsule.radius_from),
            0.0f,
            0.0f};
  if (taper <= -1.0)
    return {capsule.to.cast<float>(),
            Eigen::Vector3f::UnitZ(),
            0.0f,
            static_cast<float>(capsule.radius_to),
            0.0f,
            0.0f};
  return {
      capsule.from.cast<float>(),           ((capsule.to - capsule.from) / capsule.length()).cast<float>(),
      static_cast<float>(capsule.length()), static_cast<float>(capsule.radius_from),
      static_cast<float>(-taper),           static_cast<float>(taper / std::sqrt(1.0 - taper * taper))};
}

TACTILE_CLAY_MULTIVERSION
void addKernel(const Cone& cone, const FieldGrid::Window& window) {
  const Lane dx = window.x() - cone.from.x();
  window.forEachRow([&](float y, float z, Lane& sums) {
    const float dy = y - cone.from.y(), dz = z - cone.from.z();
    const Lane along = dx * cone.axis.x() + (dy * cone.axis.y() + dz * cone.axis.z());
    const Lane distance2 = dx * dx + (dy * dy + dz * dz);
    const Lane across = root(positive(distance2 - along * along));
    const Lane foot = min(positive(along - across * cone.lean), all(cone.length));
    const Lane aside = along - foot;
    const Lane distance = root(aside * aside + across * across) - (cone.radius + foot * cone.slope);
    const Lane u = min(positive((reach - distance) / (2.0f * reach)), all(1.0f));
    sums += u * u * u * u;
  });
}

}  // namespace

TriangleMesh CapsuleSurface::update(const std::vector<hand::Capsule>& capsules) {
  std::vector<Cone> cones;
  boxes_.clear();
  for (const hand::Capsule& capsule : capsules) {
    const double radius = std::max(capsule.radius_from, capsule.radius_to) + reach;
    const Eigen::Vector3d low = capsule.from.cwiseMin(capsule.to).array() - radius,
                          high = capsule.from.cwiseMax(capsule.to).array() + radius;
    if (!(low.minCoeff() >= -farthest_centre && high.maxCoeff() <= farthest_centre)) continue;
    cones.push_back(coneOf(capsule));
    boxes_.push_back({low.cast<float>(), high.cast<float>()});
  }
  TriangleMesh mesh;
  block_of_.clear();
  grid_.update(boxes_,
               [&](std::uint32_t k, const FieldGrid::Window& window) { addKernel(cones[k], window); });
  // The root is linear in the distance, as marching cubes assumes along edges.
  for (FieldGrid::Block& block : grid_.blocks())
    for (float& value : block.value) value = std::sqrt(std::sqrt(value));
  march(grid_, level, mesh, block_of_);
  setNormals(mesh);
  return mesh;
}

}  // namespace tactile_clay::surface
