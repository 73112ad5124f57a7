#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "oracle.h"
#include "ultrasound/focus_peak.h"
#include "ultrasound/phase_solver.h"

/// What the tests of the phase solver share: foci, and how well a drive makes them.
namespace tactile_clay::ultrasound {

class PhaseSolver : public ::testing::Test {
 protected:
  ArrayLayout layout = arrayLayout("usx");
  Acoustics air;
  std::mt19937 random{21};

  static FocalPoint point(double x, double y, double z, double intensity = 1.0) {
    FocalPoint p;
    p.position = {x, y, z};
    p.intensity = intensity;
    return p;
  }

  /// Foci at least 12 mm apart in the room a hand takes.
  std::vector<FocalPoint> randomFoci(std::size_t count) {
    std::uniform_real_distribution<double> place(-0.05, 0.05);
    std::vector<FocalPoint> foci;
    while (foci.size() < count) {
      const FocalPoint next = point(place(random), place(random), 0.18 + 0.4 * place(random));
      bool free = true;
      for (const auto& f : foci) free = free && (f.position - next.position).norm() > 0.012;
      if (free) foci.push_back(next);
    }
    return foci;
  }

  /// Distance (m) from a focus to its peak in the field of another formula; at most 8 mm.
  double distance(const Drive& drive, const Eigen::Vector3d& focus) {
    const auto amplitude = [&](const Eigen::Vector3d& at) { return heardAmplitude(layout, air, drive, at); };
    return (peakNear(focus, amplitude) - focus).norm();
  }

  /// Relative RMS of the amplitudes that an independent field has at the foci, about their common scale.
  double rmsError(const PhaseSolution& solution, const std::vector<FocalPoint>& foci) {
    std::vector<double> share;
    double mean = 0.0;
    for (std::size_t k = 0; k < foci.size(); ++k) {
      share.push_back(heardAmplitude(layout, air, solution.drive, foci[k].position) / solution.target[k]);
      mean += share.back() / static_cast<double>(foci.size());
    }
    double square = 0.0;
    for (const double s : share) square += std::pow(s / mean - 1.0, 2);
    return std::sqrt(square / static_cast<double>(foci.size()));
  }
};

}  // namespace tactile_clay::ultrasound
