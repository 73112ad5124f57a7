#include "ultrasound/side_lobes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tactile_clay::ultrasound {
namespace {

void sameLength(const char* what, std::size_t a, std::size_t b) {
  if (a == b) return;
  throw std::invalid_argument(std::string("acoustic report: ") + what + " number " + std::to_string(a) +
                              " and " + std::to_string(b) + ", expected the same");
}

}  // namespace

SideLobe strongestSideLobe(const std::vector<Eigen::Vector3f>& at,
                           const std::vector<std::complex<float>>& pressure,
                           const std::vector<FocalPoint>& foci, const std::vector<double>& achieved,
                           double away) {
  sameLength("points and pressures", at.size(), pressure.size());
  sameLength("foci and their amplitudes", foci.size(), achieved.size());
  SideLobe lobe;
  double strongest = 0.0;
  for (const double amplitude : achieved) strongest = std::max(strongest, amplitude);
  if (!(strongest > 0.0)) return lobe;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Eigen::Vector3d x = at[i].cast<double>();
    const double share = std::abs(pressure[i]) / strongest;
    if (!(share > lobe.share)) continue;
    const bool free = std::all_of(foci.begin(), foci.end(), [&](const FocalPoint& focus) {
      return (focus.position - x).norm() >= away;
    });
    if (free) lobe = {share, x};
  }
  return lobe;
}

double relativeError(const std::vector<double>& achieved, const std::vector<double>& commanded) {
  sameLength("achieved and commanded pressures", achieved.size(), commanded.size());
  std::vector<double> share;
  double mean = 0.0;
  for (std::size_t k = 0; k < achieved.size(); ++k) {
    if (commanded[k] > 0.0) share.push_back(achieved[k] / commanded[k]);
  }
  for (const double s : share) mean += s / static_cast<double>(share.size());
  if (!(mean > 0.0)) return 0.0;
  double square = 0.0;
  for (const double s : share) square += std::pow(s / mean - 1.0, 2) / static_cast<double>(share.size());
  return std::sqrt(square);
}

}  // namespace tactile_clay::ultrasound
