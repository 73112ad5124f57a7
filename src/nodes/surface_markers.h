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
/// \throws std::runtime_error naming a field that is missing
SurfaceParticles surfaceParticles(const sensor_msgs::PointCloud2& particles);

/// Colour in daylight from above: rviz does not light triangles that have colours of their own.
/// \param normal unit, in world
Eigen::Vector3f lit(const Eigen::Vector3f& color, const Eigen::Vector3f& normal);

/// The colours of all vertices of a mesh in that light.
std::vector<Eigen::Vector3f> lit(const surface::TriangleMesh& mesh);

/// Triangles of a mesh as a marker; none deletes the marker.
/// \param colors RGB of each vertex, 0-1, shown as they are: what is read from a colour bar must not be lit
/// \param alpha 0-1
visualization_msgs::Marker surfaceMarker(const surface::TriangleMesh& mesh,
                                         const std::vector<Eigen::Vector3f>& colors,
                                         const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                         float alpha, const std_msgs::Header& header, const std::string& name,
                                         int id);

}  // namespace tactile_clay::nodes
