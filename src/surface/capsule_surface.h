#pragma once

#include <cstdint>
#include <vector>

#include "hand/capsule.h"
#include "surface/field_grid.h"
#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// The surface of a hand that is made of tapered capsules: a closed manifold mesh, within half a millimetre
/// of the capsules where one is alone, and a millimetre outside of them where two meet, which it joins
/// smoothly.
///
/// Each capsule adds u^4 to a field, where u falls from 1 to 0 across 8 mm about its surface; the surface is
/// where the fourth root of the field is 1/2.
class CapsuleSurface {
 public:
  /// @param cell m, of the grid
  explicit CapsuleSurface(double cell) : grid_(static_cast<float>(cell)) {}

  /// Positions, normals and triangles; no colours. Capsules that are not finite, or farther than a kilometre
  /// from the origin, are left out.
  /// @throws std::runtime_error with one line where they are too large (FieldGrid)
  const TriangleMesh& update(const std::vector<hand::Capsule>& capsules);

 private:
  FieldGrid grid_;
  std::vector<FieldGrid::Box> boxes_;
  std::vector<std::uint32_t> block_of_;
  TriangleMesh mesh_;
};

}  // namespace tactile_clay::surface
