#include "ultrasound/array_reach.h"

#include "ultrasound/propagator.h"

namespace tactile_clay::ultrasound {

ArrayReach::ArrayReach(const ArrayLayout& layout, const Acoustics& acoustics)
    : acoustics_(acoustics), transducers_(std::make_shared<TransducerLanes>(layout)) {}

double ArrayReach::amplitude(const Eigen::Vector3d& point) const {
  return beam(point).reach;
}

FocusBeam ArrayReach::beam(const Eigen::Vector3d& point) const {
  if (!point.allFinite()) return {};
  Propagator row(1, transducers_->x.size());
  return row.addFocus(*transducers_, acoustics_, point);
}

}  // namespace tactile_clay::ultrasound
