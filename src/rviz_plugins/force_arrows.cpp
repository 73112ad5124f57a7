#include "rviz_plugins/force_arrows.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace tactile_clay::rviz_plugins {
namespace {

using Eigen::Vector3f;

constexpr int sides = 10;              // of shaft and head
constexpr float head_width = 2.4f;     // of the thickness
constexpr float head_length = 3.0f;    // of the thickness
constexpr float longest_head = 0.5f;   // share of the arrow, by which short arrows are made thinner
constexpr float furthest_cell = 1e6f;  // from the origin, along each axis: also far places have a cell

/// A ring about the axis, with its normals.
void addRing(surface::TriangleMesh& mesh, const Vector3f& middle, float radius, const Vector3f& u,
             const Vector3f& v, const Vector3f& slope) {
  for (int k = 0; k < sides; ++k) {
    const float angle = 2.0f * static_cast<float>(M_PI) * static_cast<float>(k) / sides;
    const Vector3f out = std::cos(angle) * u + std::sin(angle) * v;
    mesh.position.push_back(middle + radius * out);
    mesh.normal.push_back((out + slope).normalized());
  }
}

/// Triangles between the last two rings.
void joinRings(surface::TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.position.size()) - 2 * sides;
  for (std::uint32_t k = 0; k < sides; ++k) {
    const std::uint32_t next = (k + 1) % sides;
    mesh.triangles.push_back({first + k, first + next, first + sides + k});
    mesh.triangles.push_back({first + next, first + sides + next, first + sides + k});
  }
}

}  // namespace

std::vector<PlacedForce> gathered(const std::vector<PlacedForce>& forces, float cell) {
  struct Sum {
    Vector3f force = Vector3f::Zero(), moment = Vector3f::Zero();
    float strength = 0.0f;
  };
  std::map<std::array<int, 3>, Sum> sums;
  std::vector<PlacedForce> out;
  for (const PlacedForce& one : forces) {
    const float strength = one.force.norm();
    if (!one.at.allFinite() || !std::isfinite(strength) || !(strength > 0.0f)) continue;
    if (!(cell > 0.0f)) {
      out.push_back(one);
      continue;
    }
    std::array<int, 3> key{};
    for (int axis = 0; axis < 3; ++axis)
      key[axis] =
          static_cast<int>(std::clamp(std::floor(one.at[axis] / cell), -furthest_cell, furthest_cell));
    Sum& sum = sums[key];
    sum.force += one.force;
    sum.moment += strength * one.at;
    sum.strength += strength;
  }
  for (const auto& [key, sum] : sums) out.push_back({sum.moment / sum.strength, sum.force});
  return out;
}

void addArrow(surface::TriangleMesh& mesh, const PlacedForce& force, const ArrowLook& look) {
  const float length = look.length * force.force.norm();
  if (!(length > 0.0f)) return;
  const Vector3f along = force.force.normalized();
  const Vector3f u = along.unitOrthogonal(), v = along.cross(u);
  const float thickness = std::min(look.thickness, longest_head * length / head_length);
  const Vector3f neck = force.at - head_length * thickness * along;
  const float radius = 0.5f * thickness, head = head_width * radius;
  addRing(mesh, force.at - length * along, 0.0f, u, v, -1e3f * along);  // closes the tail
  addRing(mesh, force.at - length * along, radius, u, v, -1e3f * along);
  joinRings(mesh);
  addRing(mesh, force.at - length * along, radius, u, v, Vector3f::Zero());
  addRing(mesh, neck, radius, u, v, Vector3f::Zero());
  joinRings(mesh);
  addRing(mesh, neck, radius, u, v, -1e3f * along);
  addRing(mesh, neck, head, u, v, -1e3f * along);
  joinRings(mesh);
  const Vector3f slope = head / (head_length * thickness) * along;
  addRing(mesh, neck, head, u, v, slope);
  addRing(mesh, force.at, 0.0f, u, v, slope);
  joinRings(mesh);
}

}  // namespace tactile_clay::rviz_plugins
