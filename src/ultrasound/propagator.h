#pragma once

#include <Eigen/Core>
#include <vector>

#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/lanes.h"

namespace tactile_clay::ultrasound {

/// The transducers of a layout as structure of arrays. Lanes past the last one have no normal, so that
/// nothing is heard of them.
struct TransducerLanes {
  LaneArray<Lanes> x, y, z, nx, ny, nz;

  explicit TransducerLanes(const ArrayLayout& layout);
};

/// G of p = G q: a row a focus, its transducers in lanes (propagator scaled as its user likes).
struct Propagator {
  std::size_t foci = 0;
  std::size_t width = 0;      // lanes a row
  LaneArray<ComplexLanes> g;  // row by row
  LaneArray<ComplexLanes> s;  // x and y of the unit vectors from transducers to foci, row by row

  Propagator(std::size_t room, std::size_t row_width)
      : width(row_width), g(room * row_width), s(room * row_width) {}
  const ComplexLanes* row(std::size_t m) const { return &g[m * width]; }
  ComplexLanes* row(std::size_t m) { return &g[m * width]; }

  /// Adds a row: the pressure (Pa) of each transducer at `point` at full drive. Kept only if anything is
  /// heard. \return sum of the amplitudes of the row
  float addFocus(const TransducerLanes& transducers, const Acoustics& acoustics,
                 const Eigen::Vector3d& point);
  void scaleRow(std::size_t m, float factor);
};

/// Complex amplitudes at the foci, structure of arrays.
struct FocusField {
  Eigen::ArrayXf re, im;

  explicit FocusField(std::size_t foci)
      : re(Eigen::ArrayXf::Ones(static_cast<Eigen::Index>(foci))),
        im(Eigen::ArrayXf::Zero(static_cast<Eigen::Index>(foci))) {}
  Eigen::ArrayXf abs() const { return (re.square() + im.square()).sqrt(); }
};

using DriveLanes = LaneArray<ComplexLanes>;  // of Propagator::width

/// p = G q.
void propagate(const Propagator& g, const DriveLanes& q, FocusField& p);

/// q = conj(G)^T p: all transducers in phase at each focus, as strong as its p.
void backpropagate(const Propagator& g, const FocusField& p, DriveLanes& q);

/// R = G G^H, foci x foci.
Eigen::MatrixXcf gram(const Propagator& g);

/// How the field at the foci changes with the phases, rows of `width` lanes. With a + i b the part of each
/// transducer in p_m, turned so that p_m is real (sum a = |p_m|, sum b = 0), and s the x or y of the unit
/// vector to the focus:
/// - |p_m|: value sum a, d / dphi_n = -b_n
/// - its slope along x and y, -k sum s b, where the amplitudes' own slopes are left out (they move a peak by
///   0.2 mm): value sum s b / sum a, d / dphi_n = a_n (s_n - sum s a / sum a) / sum a
struct FocusChange {
  Eigen::ArrayXf amplitude;   // |p_m|
  Eigen::ArrayXf slope;       // of x, then y of each focus; empty: not asked for
  Eigen::ArrayXf peak_width;  // sum a (s - mean)^2 / sum a, as `slope`: slope / (k peak_width) is how far the
                              // peak is away, m
  LaneArray<Lanes> j;         // d amplitude / d phi, then d slope / d phi
};

/// \param free 1 where a phase may change, 0 where not; of width
void focusChange(const Propagator& g, const DriveLanes& q, const FocusField& p, const LaneArray<Lanes>& free,
                 bool slopes, FocusChange& change);

/// J J^T. \param rows of J, `width` lanes each
Eigen::MatrixXd rowProducts(const std::vector<const Lanes*>& rows, std::size_t width);

}  // namespace tactile_clay::ultrasound
