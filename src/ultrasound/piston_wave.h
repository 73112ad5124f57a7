#pragma once

#include <cmath>

#include "lanes/wide_lanes.h"
#include "ultrasound/acoustics.h"

namespace tactile_clay::ultrasound {

/// Constants of air and transducers for `pistonWave`.
struct PistonConstants {
  float turns_per_metre, attenuation, piston_squared, radius, inverse_radius;

  explicit PistonConstants(const Acoustics& air)
      : turns_per_metre(static_cast<float>(1.0 / air.wavelength())),
        attenuation(static_cast<float>(air.attenuation)),
        piston_squared(static_cast<float>(std::pow(air.wavenumber() * air.transducer_radius, 2))),
        radius(static_cast<float>(air.transducer_radius)),
        inverse_radius(static_cast<float>(1.0 / air.transducer_radius)) {}
};

/// The wave of one piston over a way of square length `squared`, m^2, for sixteen ways at once: its amplitude
/// D e^{-alpha r} / r and its phase k r in turns. The field of acoustic_field.h, in single precision.
/// @tparam near alpha r is at most 1/2
/// @param along the part of the way along the piston's normal, m; if it is not positive, the amplitude is 0
template <bool near>
TACTILE_CLAY_INLINE void pistonWave(const PistonConstants& air, Lanes squared, Lanes along, Lanes& amplitude,
                                    Lanes& turns) {
  squared = max(squared, Lanes{} + 1e-12f);
  const Lanes one_over = inverseRoot(squared);
  const Lanes r = squared * one_over;
  const Lanes inverse = min(one_over, Lanes{} + air.inverse_radius);
  const Lanes cosine = along * inverse;
  const Lanes u = air.piston_squared * (1.0f - cosine * cosine);
  // 2 J1(sqrt u) / sqrt u for u in [0, 16], within 1e-6: minimax polynomial (Remez).
  const Lanes directivity =
      0.99999957f + u * (-0.12499805f + u * (0.0052068899f + u * (-0.00010811540f +
                                                                  u * (1.3079104e-6f + u * -8.4793804e-9f))));
  const Lanes lost = air.attenuation * max(r, Lanes{} + air.radius);
  const Lanes heard = directivity * inverse * (near ? slightlyDecaying(lost) : decaying(lost));
  amplitude = along > 0.0f ? heard : Lanes{};
  turns = r * air.turns_per_metre;
}

/// How much of a wave presses on skin: the cosine of its incidence, max(0, -n . x / |x|), for sixteen ways at
/// once. 1 if the normal is 0: there is no skin.
/// @param x, y, z the way from the piston to the skin, m
/// @param nx, ny, nz outward normal n of the skin, of length 1 or 0
TACTILE_CLAY_INLINE Lanes onSkin(Lanes x, Lanes y, Lanes z, Lanes nx, Lanes ny, Lanes nz) {
  const Lanes squared = max(x * x + y * y + z * z, Lanes{} + 1e-12f);
  const Lanes cosine = -(x * nx + y * ny + z * nz) * inverseRoot(squared);
  return nx * nx + ny * ny + nz * nz > 0.0f ? max(cosine, Lanes{}) : Lanes{} + 1.0f;
}

}  // namespace tactile_clay::ultrasound
