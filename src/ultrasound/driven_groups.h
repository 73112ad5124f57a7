#pragma once

#include <cstdint>
#include <vector>

#include "ultrasound/piston_source.h"
#include "ultrasound/transducer_groups.h"

namespace tactile_clay::ultrasound {

/// The transducers that a drive drives, in order, and the ends of their groups at each depth.
class DrivenGroups {
 public:
  /// @param drive of the layout's length
  /// @param simple the transducers lie in one plane of equal z and look along z, and the air takes little
  DrivenGroups(const ArrayLayout& layout, const Acoustics& acoustics, const TransducerGroups& groups,
               const Drive& drive, bool simple);

  bool empty() const { return source_.empty(); }

  /// Sums over groups of |p| at sixteen points, Pa: never below |p| of the whole.
  /// @param depth of the groups; 0: the whole array
  void sums(std::size_t depth, const LanePoints& at, Lanes& sums) const;

 private:
  std::vector<PistonSource> source_;
  std::vector<std::vector<std::uint32_t>> ends_;
  PistonConstants air_;
  bool simple_;
};

}  // namespace tactile_clay::ultrasound
