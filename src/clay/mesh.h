#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "clay/solid.h"

namespace tactile_clay::clay {

/// The exact signed distance to closed surfaces of triangles. The nearest triangle is found in a tree of
/// boxes. The side of it on which a point lies follows from the normal of the nearest face, edge or corner.
/// Normals of edges and corners are weighted by angle (Baerentzen and Aanaes 2005, doi 10.1109/TVCG.2005.49).
///
/// Surfaces that are not connected are separate bodies; the mesh is their union. A surface that is turned
/// inwards inside of another one is a hole. A surface that cuts itself has no well-defined inside.
class Mesh {
 public:
  using Triangle = Eigen::Matrix<std::uint32_t, 3, 1>;  // corners, anticlockwise as seen from outside

  /// Corners nearer to each other than a millionth of the mesh's diagonal are joined. The orientation of
  /// triangles matters only for holes: all other triangles are turned outwards, as a mirrored mesh needs.
  /// @param vertices m
  /// @throws std::invalid_argument with one line if the surface is not closed, or encloses nothing
  Mesh(const std::vector<Eigen::Vector3d>& vertices, const std::vector<Triangle>& triangles);

  /// Signed distance of a point and the direction out of the mesh. Each body counts alone: inside a body the
  /// distance is that to its own surface.
  SurfacePoint surface(const Eigen::Vector3d& point) const;

  /// A lower bound of the signed distance of a point, m, at a fraction of the cost. It shows which points are
  /// too far away to matter.
  double atLeast(const Eigen::Vector3d& point) const;

  const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  double volume() const { return volume_; }  // m^3, of all bodies
  std::size_t triangles() const { return triangles_; }

  struct Face {
    Eigen::Vector3d corner[3];  // m
    Eigen::Vector3d normal;     // unit
    Eigen::Vector3d edge[3];    // normals of the edges from corner k to the next, not of unit length
    Eigen::Vector3d vertex[3];  // normals of the corners, not of unit length
  };
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0;  // first face of a leaf; else the left one of two child nodes in a row
    std::uint32_t faces = 0;  // 0: the node is no leaf
  };
  struct Body {
    std::vector<Face> faces;  // in the order of the leaves
    std::vector<Node> nodes;
  };

 private:
  void fillGrid();
  std::size_t cellOf(const Eigen::Vector3d& point, Eigen::Vector3d& centre) const;

  std::vector<Body> bodies_;
  // Signed distances of the centres of coarse cells. At another point of a cell the signed distance differs
  // at most by the way from the centre to that point.
  double cell_ = 0.0;  // m, edge
  Eigen::Array3i cells_{0, 0, 0};
  std::vector<double> distance_;  // m
  Eigen::AlignedBox3d bounds_;
  double volume_ = 0.0;
  std::size_t triangles_ = 0;
};

}  // namespace tactile_clay::clay
