#include "ultrasound/acoustics.h"

#include <algorithm>
#include <cmath>

#include "values/range.h"

namespace tactile_clay::ultrasound {
namespace {

constexpr double zero_celsius = 273.15;  // K
constexpr double max_piston = 4.0;       // largest k R for which pistonDirectivity is accurate

}  // namespace

double Acoustics::soundSpeed() const {
  return 331.3 * std::sqrt(1.0 + temperature / zero_celsius);
}

double Acoustics::airDensity() const {
  constexpr double gas_constant = 287.05;  // J/(kg K), dry air
  return 101325.0 / (gas_constant * (temperature + zero_celsius));
}

double Acoustics::wavelength() const {
  return soundSpeed() / frequency;
}

double Acoustics::wavenumber() const {
  return 2.0 * M_PI / wavelength();
}

void Acoustics::validate() const {
  values::requireIn("acoustics: temperature (degrees C)", temperature, -40.0, 60.0);
  values::requireAbove("acoustics: frequency (Hz)", frequency, 0.0);
  values::requireIn("acoustics: attenuation (Np/m)", attenuation, 0.0, 5.0);
  values::requireAbove("acoustics: reference_pressure (Pa m)", reference_pressure, 0.0);
  values::requireAbove("acoustics: transducer_radius (m)", transducer_radius, 0.0);
  const double largest = max_piston / wavenumber();
  values::requireIn("acoustics: transducer_radius (m) at this frequency", transducer_radius, 0.0, largest);
}

double radiationPressure(const Acoustics& acoustics, double amplitude) {
  const double c = acoustics.soundSpeed();
  return amplitude * amplitude / (acoustics.airDensity() * c * c);  // p_rms^2 = amplitude^2 / 2
}

double soundPressureLevel(double amplitude) {
  constexpr double reference = 20e-6;  // Pa rms
  const double rms = amplitude / std::sqrt(2.0);
  return 20.0 * std::log10(std::max(rms, reference) / reference);
}

}  // namespace tactile_clay::ultrasound
