#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/solid.h"
#include "clay/vector_field.h"

namespace tactile_clay::tools {

/// Volume, m^3, inside the surface at which the smoothed clay (sum of kernels, over its value in the lattice)
/// is one half. It is counted in cubes half a spacing wide.
/// @param position of the particles, m
/// @param spacing of their lattice, m
double volumeOf(const clay::VectorField& position, double spacing);

/// Height, m, of the highest particle plus half a spacing, above the nearest solid whose surface faces up to
/// it; 0 if there is none.
/// @param position of the particles, m
/// @param gravity m/s^2; up is against it
/// @param spacing m
double heightOf(const clay::VectorField& position, const std::vector<clay::Solid>& solids,
                const Eigen::Vector3d& gravity, double spacing);

}  // namespace tactile_clay::tools
