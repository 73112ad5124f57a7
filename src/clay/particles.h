#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// State of the clay. Particle indices never change, so that a particle can be followed through a recording.
struct Particles {
  VectorField position;              // m
  VectorField velocity;              // m/s
  std::vector<float> inverse_mass;   // 1/kg
  std::vector<float> density_ratio;  // rho / rho0
  std::vector<float> compression;    // that density may give back, see `boundExcess`
  std::vector<std::uint8_t> material;
  std::vector<std::uint16_t> body;  // index of the scene's body

  std::size_t size() const { return position.size(); }
};

}  // namespace tactile_clay::clay
