#pragma once

#include <cmath>
#include <vector>

#include "lanes/wide_lanes.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/fixed_propagator.h"
#include "ultrasound/skin_blur.h"

namespace tactile_clay::ultrasound {

/// Phases of all patterns, in turns (1 is 2 pi), one pattern after the other, sixteen transducers per
/// element.
using Turns = LaneArray<Lanes>;

/// The objective of solveField and its gradient. The unit of pressures is the largest wanted amplitude.
class FieldObjective {
 public:
  FieldObjective(const ArrayLayout& layout, const Acoustics& acoustics,
                 const std::vector<FocalPoint>& targets, const FieldSolverOptions& options);

  /// Whether no pressure is wanted, or none is possible. Then there is nothing to evaluate.
  bool silent() const { return !(unit_ > 0.0); }
  std::size_t width() const { return width_; }                 // lanes of a pattern
  std::size_t size() const { return width_ * patterns_; }      // lanes of all
  bool plain() const { return plain_; }                        // neither blurred nor weighted
  const std::vector<double>& reach() const { return reach_; }  // FieldSolution::reach

  /// Phases that send the wanted amplitudes to all targets at once: in phase in the first pattern, with other
  /// phases in each further pattern.
  Turns start();

  /// @param gradient if given, receives the derivatives with respect to the phases in turns
  double operator()(const Turns& turns, Turns* gradient);

  /// Results of the last evaluation: error and scale in the norm of the objective; amplitude on skin (Pa) at
  /// target m.
  double error() const { return std::sqrt(std::max(square_error_, 0.0)); }
  double scale() const { return scale_; }
  double amplitude(std::size_t m) const { return unit_ * std::sqrt(static_cast<double>(intensity_[m])); }

 private:
  const std::vector<float>& felt(const std::vector<float>& values, std::vector<float>& blurred) const;
  void setSlopes(double on_wanted, double on_intensity);

  double strength_;
  std::size_t patterns_, width_, count_, rows_;  // rows: targets, and empty rows up to a whole block
  FixedPropagator g_;
  std::vector<double> reach_;
  std::vector<float> wanted_, intensity_;  // squares of amplitudes
  bool plain_ = true;
  SkinBlur blur_;
  std::vector<float> weight_;              // of each target
  std::vector<float> felt_wanted_, felt_;  // wanted_ and intensity_, blurred
  std::vector<float> slope_, felt_slope_;  // derivatives of the objective by intensity_ and felt_
  std::vector<float> re_, im_;             // pressures at the targets, pattern by pattern
  LaneArray<ComplexLanes> q_, z_;          // drives, and G^T of the targets; pattern by pattern
  double unit_ = 0.0, wanted_square_ = 0.0, square_error_ = 0.0, scale_ = 0.0;
};

}  // namespace tactile_clay::ultrasound
