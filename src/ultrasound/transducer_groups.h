#pragma once

#include <cstdint>
#include <vector>

#include "ultrasound/array_layout.h"

namespace tactile_clay::ultrasound {

/// Groups of neighbouring transducers: at most four form a group, two neighbouring groups form a larger one,
/// and so on up to the whole array.
struct TransducerGroups {
  std::vector<std::uint32_t> order;              // indices of the transducers
  std::vector<std::vector<std::uint32_t>> ends;  // of the groups in `order`, by depth: the whole array first

  /// @param layout with at least one transducer
  explicit TransducerGroups(const ArrayLayout& layout);
};

}  // namespace tactile_clay::ultrasound
