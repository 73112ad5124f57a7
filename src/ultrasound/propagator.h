#pragma once

#include <Eigen/Core>
#include <vector>

#include "lanes/wide_lanes.h"
#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/focus_beam.h"
#include "ultrasound/piston_wave.h"

namespace tactile_clay::ultrasound {

/// The transducers of a layout as structure of arrays. Lanes past the last one have no normal, so that
/// nothing is heard of them.
struct TransducerLanes {
  LaneArray<Lanes> x, y, z, nx, ny, nz;

  explicit TransducerLanes(const ArrayLayout& layout);
};

/// The waves of sixteen transducers at a point, at full drive.
struct LaneWaves {
  Lanes x, y, z, squared;  // m, from the transducers to the point; m^2, their distance
  Lanes amplitude;         // Pa
  ComplexLanes pressure;   // Pa
};
/// @param i which sixteen
/// @param strength P_ref, Pa m
/// @param point m
TACTILE_CLAY_INLINE LaneWaves wavesAt(const TransducerLanes& t, std::size_t i, const PistonConstants& air,
                                      float strength, const float* point) {
  LaneWaves w;
  w.x = point[0] - t.x[i];
  w.y = point[1] - t.y[i];
  w.z = point[2] - t.z[i];
  w.squared = w.x * w.x + w.y * w.y + w.z * w.z;
  Lanes turns;
  Lanes cosine;
  Lanes sine;
  pistonWave<false>(air, w.squared, w.x * t.nx[i] + w.y * t.ny[i] + w.z * t.nz[i], w.amplitude, turns);
  unitCircle(turns, cosine, sine);
  w.amplitude *= strength;
  w.pressure = {w.amplitude * cosine, w.amplitude * sine};
  return w;
}

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
  /// heard.
  FocusBeam addFocus(const TransducerLanes& transducers, const Acoustics& acoustics,
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

/// The field at the foci, transducer by transducer. With a + i b the part of each in p_m, turned so that p_m
/// is real (sum a = |p_m|, sum b = 0): |p_m| changes with the phases by -b.
struct FocusParts {
  Eigen::ArrayXf amplitude;        // |p_m|
  LaneArray<Lanes> along, across;  // a and -b, rows of Propagator::width
};
void focusParts(const Propagator& g, const DriveLanes& q, const FocusField& p, FocusParts& parts);

/// The amplitude around a focus in its plane of equal z: at a way d aside it is |p| (1 - k slope d - k^2 d^T
/// width d / 2), so that the peak is at d = -width^-1 slope / k, if width is positive definite. The
/// amplitudes' own slopes are left out; they move a peak by 0.2 mm.
struct PeakShape {
  Eigen::Vector2f slope =
      Eigen::Vector2f::Zero();  // sum s b / sum a, s being the x and y of the unit vectors to the focus
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();  // of s, weighted by a
  Eigen::Matrix2f width =
      Eigen::Matrix2f::Zero();  // covariance of s, weighted by a; not positive between the lobes of others
};
PeakShape peakShape(const Propagator& g, const FocusParts& parts, std::size_t m);

/// How the slope along the unit vector u changes with the phases: a (s u - mean u) / sum a.
void slopeRow(const Propagator& g, const FocusParts& parts, std::size_t m, const PeakShape& shape,
              const Eigen::Vector2f& u, Lanes* row);

/// How the width along u changes with the phases: -b ((s u - mean u)^2 - u^T width u) / sum a.
void widthRow(const Propagator& g, const FocusParts& parts, std::size_t m, const PeakShape& shape,
              const Eigen::Vector2f& u, Lanes* row);

/// J J^T.
/// @param rows of J, `width` lanes each
Eigen::MatrixXd rowProducts(const std::vector<const Lanes*>& rows, std::size_t width);

}  // namespace tactile_clay::ultrasound
