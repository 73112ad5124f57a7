#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/vector_field.h"
#include "surface/coloured_particles.h"
#include "surface/kernels.h"

namespace tactile_clay::surface {

/// One particle of the clay, as a graphics card draws it.
struct Splat {
  EllipsoidKernel kernel;
  Eigen::Vector3f color;  // RGB, 0-1
};

/// The kernels of those particles on which the surface of the clay can depend, for a picture by ellipsoid
/// splatting. Their sum at the surface is the sum of all kernels (class ClaySurface) within some hundredths.
/// A particle is left out if neither it nor any of its neighbours lacks neighbours.
class ClaySplats {
 public:
  /// @param spacing m, of the particles
  /// @throws std::invalid_argument if it is not from 1 to 20 mm
  explicit ClaySplats(double spacing);

  /// @param position m, of n particles; particles that are not within a kilometre of the origin are left out
  /// @param color RGB, 0-1, of each particle
  /// @throws std::invalid_argument if there is not one colour per particle
  std::vector<Splat> update(const clay::VectorField& position, const std::vector<Eigen::Vector3f>& color);

  std::size_t particles() const { return particles_.color.size(); }  // from which the splats were chosen
  double spacing() const { return spacing_; }

 private:
  void findOuter(const std::vector<EllipsoidKernel>& kernels);

  double spacing_;
  Kernels kernels_;
  ColouredParticles particles_;
  std::vector<char> outer_;  // of each particle: whether it lacks neighbours
};

}  // namespace tactile_clay::surface
