#pragma once

#include <cstdint>
#include <vector>

#include "ultrasound/array_layout.h"

namespace tactile_clay::ultrasound {

/// Neighbours with neighbours: groups of at most four transducers, these in pairs, and so on up to the whole
/// array.
struct TransducerGroups {
  std::vector<std::uint32_t> order;              // transducers
  std::vector<std::vector<std::uint32_t>> ends;  // of the groups in `order`, by depth: the whole array first

  /// @param layout of one transducer at least
  explicit TransducerGroups(const ArrayLayout& layout);
};

}  // namespace tactile_clay::ultrasound
