#include "ultrasound/focus_peak.h"

#include <algorithm>
#include <cmath>

namespace tactile_clay::ultrasound {
namespace {

constexpr double first_step = 0.0016, last_step = 0.0002, farthest = 0.008;  // m
constexpr int around = 16;  // places on the circle; half as many on each of two circles inside it

}  // namespace

Eigen::Vector3d peakNear(const Eigen::Vector3d& point,
                         const std::function<double(const Eigen::Vector3d&)>& amplitude) {
  Eigen::Vector3d here = point;
  double best = amplitude(here);
  for (double step = first_step; step >= last_step;) {
    Eigen::Vector3d next = here;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        const Eigen::Vector3d at = here + step * Eigen::Vector3d(x, y, 0.0);
        if ((x == 0 && y == 0) || (at - point).norm() > farthest) continue;
        const double there = amplitude(at);
        if (there <= best) continue;
        best = there;
        next = at;
      }
    }
    if (next == here) step *= 0.5;
    here = next;
  }
  return here;
}

std::size_t peaksWithin(double radius, const ArrayLayout& layout, const Acoustics& acoustics,
                        const Drive& drive, const std::vector<FocalPoint>& points) {
  std::vector<Eigen::Vector3d> ways;  // the circle first
  const auto circle = [&](int places, double share) {
    for (int k = 0; k < places; ++k) {
      const double angle = 2.0 * M_PI * k / places;
      ways.emplace_back(share * radius * std::cos(angle), share * radius * std::sin(angle), 0.0);
    }
  };
  circle(around, 1.0);
  circle(around / 2, 2.0 / 3.0);
  circle(around / 2, 1.0 / 3.0);
  ways.emplace_back(Eigen::Vector3d::Zero());
  std::vector<Eigen::Vector3f> places;
  for (const FocalPoint& point : points) {
    for (const Eigen::Vector3d& way : ways) places.emplace_back((point.position + way).cast<float>());
  }
  const std::vector<std::complex<float>> pressure = pressuresAt(layout, acoustics, drive, places);
  std::size_t peaks = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto strongest = [&](std::size_t from, std::size_t to) {
      float maximum = 0.0f;
      for (std::size_t i = from; i < to; ++i)
        maximum = std::max(maximum, std::abs(pressure[k * ways.size() + i]));
      return maximum;
    };
    if (strongest(around, ways.size()) > strongest(0, around)) ++peaks;
  }
  return peaks;
}

}  // namespace tactile_clay::ultrasound
