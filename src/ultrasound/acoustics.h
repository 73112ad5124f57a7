#pragma once

namespace tactile_clay::ultrasound {

/// The air, and transducers as pistons in a baffle.
struct Acoustics {
  double frequency = 40000.0;         // Hz
  double temperature = 20.0;          // of the air, degrees C
  double attenuation = 0.15;          // of the amplitude, Np/m; 1.3 dB/m at 40 kHz
  double transducer_radius = 0.0045;  // m
  double reference_pressure = 3.4;    // peak pressure of one transducer at full drive, Pa m (AcousTools)

  double soundSpeed() const;  // m/s, ideal gas: 331.3 sqrt(T / 273.15 K)
  double airDensity() const;  // kg/m^3, dry air at 101 325 Pa
  double wavelength() const;  // m
  double wavenumber() const;  // rad/m

  /// @throws std::invalid_argument naming the parameter, its value and its range. The directivity is
  ///   evaluated to rounding for k R up to 4 (5.4 mm at 40 kHz), the range of wavenumber times radius that is
  ///   accepted
  void validate() const;
};

/// Directivity of a piston, 2 J1(x) / x, as a power series in x^2 whose error is below 1e-6 up to x = 4,
/// where x = k R sin(theta). Eight powers, so that it needs no Bessel function and compilers vectorise it.
template <typename T>
constexpr T pistonDirectivity(T x_squared) {
  // sum over m of (-u)^m / (m! (m+1)!), u = x^2/4
  const T u = x_squared * T(0.25);
  return T(1) +
         u * (T(-1.0 / 2) +
              u * (T(1.0 / 12) +
                   u * (T(-1.0 / 144) + u * (T(1.0 / 2880) + u * (T(-1.0 / 86400) +
                                                                  u * (T(1.0 / 3628800) +
                                                                       u * (T(-1.0 / 203212800) +
                                                                            u * T(1.0 / 14631321600.0))))))));
}

/// Mean radiation pressure of a wave on a rigid surface, Pa: 2 p_rms^2 / (rho c^2).
/// @param amplitude peak acoustic pressure, Pa
double radiationPressure(const Acoustics& acoustics, double amplitude);

/// Sound pressure level, dB re 20 uPa rms; 0 for silence and anything below 20 uPa.
/// @param amplitude peak acoustic pressure, Pa
double soundPressureLevel(double amplitude);

}  // namespace tactile_clay::ultrasound
