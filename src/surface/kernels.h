#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/neighbourhood.h"
#include "clay/vector_field.h"

namespace tactile_clay::surface {

/// The part of one particle in the field of the clay at x: weight (1 - q)^3 for q = d^T shape d < 1, with d =
/// x - centre.
struct EllipsoidKernel {
  Eigen::Vector3f centre;  // m
  Eigen::Matrix3f shape;   // 1/m^2, symmetric; the kernel ends at the ellipsoid q = 1
  Eigen::Vector3f reach;   // m, half extents of the ellipsoid's box
  float weight;            // so that the field is about 1 inside of the clay
};

/// Kernels that are wide along the surface of the clay and narrow across it (Yu and Turk 2013,
/// "Reconstructing surfaces of particle-based fluids using anisotropic kernels",
/// doi 10.1145/2421636.2421641): the surface is flat on flat clay, and yet edges stay sharp. C is the
/// covariance of a particle's neighbourhood, weighted with the kernel of a lattice, and c the variance in a
/// full lattice. Then shape^-1 = R^2 ((1 - b) C / c + b I). Yu and Turk bound the eigenvalues of C; b does so
/// smoothly, without eigenvectors. The weights make the field 1 at a particle that is alone, and in a full
/// lattice.
class Kernels {
 public:
  /// @param spacing m, of the particles
  /// @throws std::invalid_argument if it is not from 1 to 20 mm
  explicit Kernels(double spacing);

  /// @param position m, finite
  std::vector<EllipsoidKernel> update(const clay::VectorField& position);

  float reach() const { return radius_; }  // m, of the kernel of a particle in a full lattice
  /// Pairs of particles of the last update that are within that reach.
  const clay::Neighbourhood& neighbourhood() const { return near_; }

 private:
  float radius_;                     // m, R
  float lattice_sum_, lattice_var_;  // of weights, and variance along an axis (m^2), in a full lattice
  clay::Neighbourhood near_;
};

}  // namespace tactile_clay::surface
