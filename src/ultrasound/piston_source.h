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
/// @tparam simple sources lie in one plane of equal z and look along z, and the air takes little
/// @param height of the points over that plane, m, and its square; read only where it is simple
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

}  // namespace tactile_clay::ultrasound
