#include "ultrasound/slip.h"

#include <algorithm>
#include <cmath>

namespace tactile_clay::ultrasound {

double slipWave(double t) {
  return 0.5 - 0.25 * (std::cos(2.0 * M_PI * slip_low * t) + std::cos(2.0 * M_PI * slip_high * t));
}

double withSlip(double amplitude, double slip, double wave) {
  return std::sqrt((1.0 - slip) * amplitude * amplitude + slip * wave);
}

double slipShare(const std::vector<contact::PressureSample>& samples, double gain) {
  double all = 0.0;
  double slides = 0.0;
  for (const contact::PressureSample& sample : samples) {
    const double force = static_cast<double>(sample.pressure) * sample.area;
    if (!(std::isfinite(force) && force > 0.0 && std::isfinite(sample.slip))) continue;
    all += force;
    slides += force * std::clamp(gain * sample.slip, 0.0, 1.0);
  }
  return all > 0.0 ? slides / all : 0.0;
}

}  // namespace tactile_clay::ultrasound
