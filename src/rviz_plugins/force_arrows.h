#pragma once

#include <Eigen/Core>
#include <vector>

#include "surface/triangle_mesh.h"

namespace tactile_clay::rviz_plugins {

/// A force and the place where it acts.
struct PlacedForce {
  Eigen::Vector3f at = Eigen::Vector3f::Zero(), force = Eigen::Vector3f::Zero();  // m, N
};

/// The sums of the forces in each cube of a grid. A sum acts at the mean of their places, weighted by their
/// strengths. The sum of all forces stays the same. Forces that are not finite are left out.
/// @param cell m, edge of the cubes; 0: each force by itself
std::vector<PlacedForce> gathered(const std::vector<PlacedForce>& forces, float cell);

/// How arrows are drawn.
struct ArrowLook {
  float length = 0.01f;      // m per N
  float thickness = 0.003f;  // m, diameter of the shaft; less for short arrows
};

/// Appends an arrow whose tip is where the force acts. Without colours; no arrow for a force of zero.
void addArrow(surface::TriangleMesh& mesh, const PlacedForce& force, const ArrowLook& look);

}  // namespace tactile_clay::rviz_plugins
