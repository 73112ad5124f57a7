#pragma once

#include <vector>

#include "ultrasound/newton_steps.h"
#include "ultrasound/phase_rounding.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound {

/// Solves p = G q for |p| = 1 at every focus, up to a common scale, by one of the methods of solvePhases.
class FocusSolver {
 public:
  /// @param transducers number of transducers of `g`, without the empty lanes at the end
  /// @param wavenumber rad/m
  /// @param shapes of the foci; empty: only amplitudes count
  FocusSolver(Propagator g, std::size_t transducers, double wavenumber, std::vector<FocusShape> shapes,
              const PhaseSolverOptions& options);

  /// Lets solve() start from the phases that this drive has at the foci.
  void start(const DriveLanes& q);

  /// @param power start weights w with which G^H w gives equal foci: target squared
  void solve(const Eigen::ArrayXf& power);

  /// Turns the phases of all drives by one angle, so that they are as close as possible to the drive before,
  /// then limits the change of each.
  void limit(const PhaseLimit& limit, const DriveLanes& before);

  DriveLanes& q() { return q_; }
  const Propagator& g() const { return g_; }

  /// G q.
  FocusField p() const;

 private:
  void emit(const Eigen::ArrayXf& weight);
  void gerchbergSaxton(const Eigen::ArrayXf& first, int passes);
  Eigen::ArrayXf amongFoci(int passes);
  Eigen::ArrayXf strongest();
  void startAnew();
  void correct(const LaneArray<Lanes>& free);

  Propagator g_;
  std::size_t transducers_;
  double wavenumber_;
  PhaseSolverOptions options_;
  std::vector<FocusShape> shapes_;
  DriveLanes q_;
  FocusField p_;
  bool warm_ = false;
};

}  // namespace tactile_clay::ultrasound
