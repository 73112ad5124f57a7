#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/solid.h"
#include "clay/vector_field.h"

namespace tactile_clay::tools {

/// Volume, m^3, within the surface where the smoothed clay, the sum of kernels over that within the lattice,
/// is one half. Counted in cubes half a spacing wide.
/// @param position of the particles, m
/// @param spacing of their lattice, m
double volumeOf(const clay::VectorField& position, double spacing);

/// Height, m, of the highest particle, half a spacing thick, over the nearest of the solids that face up to
/// it; 0 if none does.
/// @param position of the particles, m
/// @param gravity m/s^2; up is against it
/// @param spacing m
double heightOf(const clay::VectorField& position, const std::vector<clay::Solid>& solids,
                const Eigen::Vector3d& gravity, double spacing);

}  // namespace tactile_clay::tools
