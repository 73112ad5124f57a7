#pragma once

#include <Eigen/Core>
#include <cmath>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/piston_wave.h"

namespace tactile_clay::ultrasound {

/// One driven transducer, prepared for single precision.
struct PistonSource {
  float x, y, z;
  float nx, ny, nz;
  float strength, turns;  // P_ref a, Pa m; phi
};

/// Transducer n of a layout with its drive.
inline PistonSource pistonSource(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
                                 std::size_t n) {
  const Eigen::Vector3f x = layout.position[n].cast<float>(), normal = layout.normal[n].cast<float>();
  return {x.x(),
          x.y(),
          x.z(),
          normal.x(),
          normal.y(),
          normal.z(),
          static_cast<float>(acoustics.reference_pressure * drive.amplitude[n]),
          static_cast<float>(std::remainder(drive.phase[n] / (2.0 * M_PI), 1.0))};
}

/// Places of sixteen points, m.
struct LanePoints {
  Lanes x, y, z;
};

/// Adds the pressure of a source at sixteen points to `re` and `im`, Pa.
/// @tparam simple sources lie in one plane of equal z and look along z, and the air attenuates little
/// @param height, height_squared of the points over that plane, m and m^2; read only if `simple`
template <bool simple>
TACTILE_CLAY_INLINE void addWave(const PistonSource& source, const PistonConstants& air, const LanePoints& at,
                                 const Lanes& height, const Lanes& height_squared, Lanes& re, Lanes& im) {
  const Lanes dx = at.x - source.x;
  const Lanes dy = at.y - source.y;
  Lanes amplitude;
  Lanes turns;
  Lanes cosine;
  Lanes sine;
  if (simple) {
    pistonWave<true>(air, dx * dx + dy * dy + height_squared, height, amplitude, turns);
  } else {
    const Lanes dz = at.z - source.z;
    pistonWave<false>(air, dx * dx + dy * dy + dz * dz, dx * source.nx + dy * source.ny + dz * source.nz,
                      amplitude, turns);
  }
  unitCircle(turns + source.turns, cosine, sine);
  amplitude *= source.strength;
  re += amplitude * cosine;
  im += amplitude * sine;
}

/// Adds what presses of the pressure of a source on skin at sixteen points (onSkin) to `re` and `im`, Pa.
/// @param normal of the skin, of length 1 or 0
TACTILE_CLAY_INLINE void addWaveOnSkin(const PistonSource& source, const PistonConstants& air,
                                       const LanePoints& at, const LanePoints& normal, Lanes& re, Lanes& im) {
  const Lanes counts =
      onSkin(at.x - source.x, at.y - source.y, at.z - source.z, normal.x, normal.y, normal.z);
  Lanes wave_re{}, wave_im{};
  addWave<false>(source, air, at, Lanes{}, Lanes{}, wave_re, wave_im);
  re += counts * wave_re;
  im += counts * wave_im;
}

}  // namespace tactile_clay::ultrasound
