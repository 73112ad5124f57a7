#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "ultrasound/acoustic_field.h"

namespace tactile_clay::ultrasound {

/// Pressure amplitude (Pa peak), computed in another way than in the library: every transducer sends
/// cos(omega t - phi), which arrives after the time that sound needs. The signals are added up as samples
/// over one period, and the amplitude is sqrt(2) times their rms. Directivity is by the standard library's
/// Bessel function.
inline double heardAmplitude(const ArrayLayout& layout, const Acoustics& air, const Drive& drive,
                             const Eigen::Vector3d& point) {
  constexpr int samples = 8;  // of one period; exact for a sine
  const double c = 331.3 * std::sqrt(1.0 + air.temperature / 273.15);
  double heard[samples] = {};
  for (std::size_t n = 0; n < layout.size(); ++n) {
    const Eigen::Vector3d d = point - layout.position[n];
    const double distance = std::sqrt(d.dot(d));
    const double angle = std::atan2(std::hypot(d.x(), d.y()), d.z());
    const double x = 2.0 * M_PI * air.frequency / c * air.transducer_radius * std::sin(angle);
    const double directivity = x < 1e-9 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, x) / x;
    const double level = air.reference_pressure * drive.amplitude[n] * directivity / distance *
                         std::exp(-air.attenuation * distance);
    for (int s = 0; s < samples; ++s) {
      const double t = s / (samples * air.frequency);
      heard[s] += level * std::cos(2.0 * M_PI * air.frequency * (t - distance / c) - drive.phase[n]);
    }
  }
  double square = 0.0;
  for (const double h : heard) square += h * h;
  return std::sqrt(2.0 * square / samples);
}

}  // namespace tactile_clay::ultrasound
