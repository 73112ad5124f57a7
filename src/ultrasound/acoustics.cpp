#include "ultrasound/acoustics.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tactile_clay::ultrasound {
namespace {

constexpr double zero_celsius = 273.15;  // K
constexpr double max_piston = 4.0;       // largest k R for which pistonDirectivity is accurate

void require(bool holds, const char* name, double value, const char* expected) {
  if (holds) return;
  throw std::invalid_argument("acoustics: " + std::string(name) + " is " + std::to_string(value) +
                              ", expected " + expected);
}

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
  require(temperature >= -40.0 && temperature <= 60.0, "temperature", temperature, "-40 to 60 degrees C");
  require(frequency > 0.0 && std::isfinite(frequency), "frequency", frequency, "a positive number of Hz");
  require(attenuation >= 0.0 && attenuation <= 5.0, "attenuation", attenuation, "0 to 5 Np/m");
  require(reference_pressure > 0.0 && std::isfinite(reference_pressure), "reference_pressure",
          reference_pressure, "a positive number of Pa m");
  const double largest = max_piston / wavenumber();
  require(transducer_radius > 0.0 && transducer_radius <= largest, "transducer_radius", transducer_radius,
          ("above 0 and at most " + std::to_string(largest) + " m at this frequency").c_str());
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
