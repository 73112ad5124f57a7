#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/vector_field.h"
#include "surface/coloured_particles.h"
#include "surface/field_grid.h"
#include "surface/kernels.h"
#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// The surface of clay that is given as particles: a closed manifold mesh that encloses the clay's volume.
///
/// The field of the kernels (class Kernels) is summed on a grid of half a spacing. The surface is at the
/// level of the field at which it encloses one spacing^3 per particle, limited to 0.3 to 0.8. Marching cubes
/// (class CellPolygons) makes the triangles. The same particles always give the same bits.
class ClaySurface {
 public:
  /// @param spacing m, of the particles
  /// @throws std::invalid_argument if it is not from 1 to 20 mm
  explicit ClaySurface(double spacing);

  /// @param position m; particles that are not within a kilometre of the origin are left out
  /// @param color RGB, 0-1, of each particle; where bodies merge, colours blend over the width of a kernel
  /// @throws std::invalid_argument if there is not one colour per particle, std::runtime_error with one line
  ///   if the clay is spread too far (FieldGrid)
  TriangleMesh update(const clay::VectorField& position, const std::vector<Eigen::Vector3f>& color);

  float level() const { return level_; }  // of the field, at the surface
  double spacing() const { return spacing_; }

 private:
  void paint(const std::vector<EllipsoidKernel>& kernels, TriangleMesh& mesh) const;

  double spacing_;
  float level_ = 0.0f;
  Kernels kernels_;
  FieldGrid grid_;
  std::vector<FieldGrid::Box> boxes_;    // of the kernels
  ColouredParticles particles_;          // without those that are left out
  std::vector<std::uint32_t> block_of_;  // block of each corner of the mesh
};

}  // namespace tactile_clay::surface
