#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "clay/solid.h"

namespace tactile_clay::clay {

/// The exact signed distance to closed surfaces of triangles. The nearest triangle is found in a tree of
/// boxes; which side of it a point is on is told by the normal of the face, edge or corner that is nearest,
/// where those of edges and corners are weighted by angle (Baerentzen and Aanaes 2005,
/// doi 10.1109/TVCG.2005.49).
///
/// Surfaces that are apart from each other are bodies of their own, whose union counts; one inside another
/// that is turned inwards is a hole. A surface that cuts itself has no inside that is well defined.
class Mesh {
 public:
  using Triangle = Eigen::Matrix<std::uint32_t, 3, 1>;  // corners, anticlockwise as seen from outside

  /// Corners nearer to each other than a millionth of the mesh are one. How triangles are turned does not
  /// matter, but for holes: they are turned outwards, as a mirrored mesh needs.
  /// @param vertices m
  /// @throws std::invalid_argument with one line where the surface is not closed, or encloses nothing
  Mesh(const std::vector<Eigen::Vector3d>& vertices, const std::vector<Triangle>& triangles);

  /// Signed distance of a point and the direction out of the mesh. Bodies do not see each other: inside one
  /// the distance is that to its own surface.
  SurfacePoint surface(const Eigen::Vector3d& point) const;

  /// A number that the signed distance of a point is not less than, m, at a fraction of the cost: it tells
  /// what is too far off to matter.
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
    std::uint32_t first = 0;  // face, or the left one of two nodes that follow each other
    std::uint32_t faces = 0;  // 0: no leaf
  };
  struct Body {
    std::vector<Face> faces;  // in the order of the leaves
    std::vector<Node> nodes;
  };

 private:
  void fillGrid();
  std::size_t cellOf(const Eigen::Vector3d& point, Eigen::Vector3d& centre) const;

  std::vector<Body> bodies_;
  // Distances of the centres of coarse cells, from which no point of a cell differs by more than it is away.
  double cell_ = 0.0;  // m, edge
  Eigen::Array3i cells_{0, 0, 0};
  std::vector<double> distance_;  // m
  Eigen::AlignedBox3d bounds_;
  double volume_ = 0.0;
  std::size_t triangles_ = 0;
};

}  // namespace tactile_clay::clay
