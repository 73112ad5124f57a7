#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/Marker.h>

#include <string>
#include <vector>

#include "clay/vector_field.h"
#include "surface/triangle_mesh.h"

namespace tactile_clay::nodes {

/// clay/particles as its surface needs them.
struct SurfaceParticles {
  clay::VectorField position;          // m
  std::vector<Eigen::Vector3f> color;  // RGB, 0-1
};
/// @throws std::runtime_error naming a field that is missing
SurfaceParticles surfaceParticles(const sensor_msgs::PointCloud2& particles);

/// Directions towards two lights, in world, unit, and how much comes from them: the sun behind the left
/// shoulder of the default view, a weak light from the other side.
struct Daylight {
  Eigen::Vector3f sun = Eigen::Vector3f(-0.55f, 0.25f, 0.85f).normalized();
  Eigen::Vector3f fill = Eigen::Vector3f(-0.45f, -0.75f, 0.25f).normalized();
  float from_below = 0.34f, from_sky = 0.20f, from_sun = 0.46f, from_fill = 0.14f;  // shares of a colour
};

/// Colour in daylight from above: rviz does not light triangles that have colours of their own.
/// @param normal unit, in world
Eigen::Vector3f lit(const Eigen::Vector3f& color, const Eigen::Vector3f& normal);

/// The colours of all vertices of a mesh in that light.
std::vector<Eigen::Vector3f> lit(const surface::TriangleMesh& mesh);

/// Triangles of a mesh as a marker; none deletes the marker.
/// @param colors RGB of each vertex, 0-1, shown as they are: what is read from a colour bar must not be lit
/// @param alpha 0-1
visualization_msgs::Marker surfaceMarker(const surface::TriangleMesh& mesh,
                                         const std::vector<Eigen::Vector3f>& colors,
                                         const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                         float alpha, const std_msgs::Header& header, const std::string& name,
                                         int id);

}  // namespace tactile_clay::nodes
