#include "ultrasound/felt_force.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tactile_clay::ultrasound {
namespace {

constexpr double finger_threshold = 0.4e-3;               // N, at 200 Hz
constexpr double threshold_low = 150.0;                   // Hz, from which on the threshold of 200 Hz is used
constexpr double threshold_high = 250.0;                  // Hz, up to which it is used
constexpr double lateral_equivalence = 0.21 / 0.027;      // felt N per N
constexpr double lateral_low = 5.0, lateral_high = 15.0;  // Hz
constexpr double circle_equivalence = 10.9;               // felt N per N
constexpr double circle_low = 4.0, circle_high = 6.0;     // Hz

}  // namespace

double spotArea(const Acoustics& acoustics, const FocusBeam& beam) {
  const double variance = beam.spread.topLeftCorner<2, 2>().cast<double>().determinant();
  return variance > 0.0 ? std::pow(acoustics.wavelength(), 2) / (12.0 * std::sqrt(variance)) : 0.0;
}

FeltForce feltForce(Modulation modulation, double frequency, double force) {
  FeltForce felt;
  const bool swells = modulation == Modulation::amplitude || modulation == Modulation::field;
  if (swells && frequency >= threshold_low && frequency <= threshold_high && force > 0.0)
    felt.vibration = std::max(0.0, 20.0 * std::log10(force / finger_threshold));
  if (modulation == Modulation::lateral && frequency >= lateral_low && frequency <= lateral_high)
    felt.pressure = lateral_equivalence * force;
  const bool circles = modulation == Modulation::circle || modulation == Modulation::field_circle;
  if (circles && frequency >= circle_low && frequency <= circle_high)
    felt.pressure = circle_equivalence * force;
  return felt;
}

}  // namespace tactile_clay::ultrasound
