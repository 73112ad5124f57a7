#pragma once

#include <cstdint>
#include <vector>

#include "hand/capsule.h"
#include "surface/field_grid.h"
#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// The surface of a hand that is made of tapered capsules: a closed manifold mesh. It is within half a
/// millimetre of a capsule that is alone. Where two capsules meet it joins them smoothly, a millimetre
/// outside of them.
///
/// Each capsule adds u^4 to a field, where u falls from 1 to 0 across 8 mm about its surface. On the surface
/// of the hand the fourth root of the field is 1/2.
class CapsuleSurface {
 public:
  /// @param cell m, of the grid
  explicit CapsuleSurface(double cell) : grid_(static_cast<float>(cell)) {}

  /// Positions, normals and triangles; no colours. Capsules that are not finite, or farther than a kilometre
  /// from the origin, are left out.
  /// @throws std::runtime_error with one line if they are too large (FieldGrid)
  TriangleMesh update(const std::vector<hand::Capsule>& capsules);

 private:
  FieldGrid grid_;
  std::vector<FieldGrid::Box> boxes_;
  std::vector<std::uint32_t> block_of_;
};

}  // namespace tactile_clay::surface
