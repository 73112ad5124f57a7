#pragma once

#include <vector>

#include "ultrasound/newton_steps.h"
#include "ultrasound/phase_rounding.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound {

/// Solves p = G q for |p| = 1 at every focus, up to a common scale, by one of the methods of solvePhases.
class FocusSolver {
 public:
  /// @param transducers of `g`, the lanes past the last one left out
  /// @param wavenumber rad/m
  /// @param shapes of the foci; empty: amplitudes are all that counts
  FocusSolver(Propagator g, std::size_t transducers, double wavenumber, std::vector<FocusShape> shapes,
              const PhaseSolverOptions& options);

  /// From the phases that this drive has at the foci.
  void start(const DriveLanes& q);

  /// @param power weights that give equal foci in G^H w: target squared
  void solve(const Eigen::ArrayXf& power);

  /// Turns all drives together to be as close as they can to the drive before, then each to its limit.
  void limit(const PhaseLimit& limit, const DriveLanes& before);

  DriveLanes& q() { return q_; }
  const Propagator& g() const { return g_; }

  /// G q.
  const FocusField& p();

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
