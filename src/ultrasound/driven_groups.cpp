#include "ultrasound/driven_groups.h"

namespace tactile_clay::ultrasound {
namespace {

template <bool simple>
TACTILE_CLAY_INLINE Lanes groupSum(const PistonSource* sources, const std::uint32_t* ends, std::size_t groups,
                                   const PistonConstants& air, const LanePoints& at) {
  Lanes total{};
  const Lanes height = at.z - sources[0].z;
  const Lanes height_squared = height * height;
  std::uint32_t n = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    Lanes re{};
    Lanes im{};
    for (; n < ends[group]; ++n) addWave<simple>(sources[n], air, at, height, height_squared, re, im);
    const Lanes squared = max(re * re + im * im, Lanes{} + 1e-30f);
    total += squared * inverseRoot(squared);
  }
  return total;
}

TACTILE_CLAY_MULTIVERSION void sumSimpleGroups(const PistonSource* sources, const std::uint32_t* ends,
                                               std::size_t groups, const PistonConstants& air,
                                               const LanePoints& at, Lanes* sums) {
  *sums = groupSum<true>(sources, ends, groups, air, at);
}

TACTILE_CLAY_MULTIVERSION void sumAnyGroups(const PistonSource* sources, const std::uint32_t* ends,
                                            std::size_t groups, const PistonConstants& air,
                                            const LanePoints& at, Lanes* sums) {
  *sums = groupSum<false>(sources, ends, groups, air, at);
}

}  // namespace

DrivenGroups::DrivenGroups(const ArrayLayout& layout, const Acoustics& acoustics,
                           const TransducerGroups& groups, const Drive& drive, bool simple)
    : ends_(groups.ends.size()), air_(acoustics), simple_(simple) {
  // Number of driven transducers among the first n in order.
  std::vector<std::uint32_t> driven(groups.order.size() + 1, 0);
  for (std::size_t n = 0; n < groups.order.size(); ++n) {
    const std::size_t t = groups.order[n];
    if (drive.amplitude[t] != 0.0f) source_.push_back(pistonSource(layout, acoustics, drive, t));
    driven[n + 1] = static_cast<std::uint32_t>(source_.size());
  }
  for (std::size_t depth = 0; depth < ends_.size(); ++depth)
    for (const std::uint32_t end : groups.ends[depth]) ends_[depth].push_back(driven[end]);
}

void DrivenGroups::sums(std::size_t depth, const LanePoints& at, Lanes& sums) const {
  (simple_ ? sumSimpleGroups : sumAnyGroups)(source_.data(), ends_[depth].data(), ends_[depth].size(), air_,
                                             at, &sums);
}

}  // namespace tactile_clay::ultrasound
