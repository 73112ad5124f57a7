#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/contact/contacts.h"
#include "clay/forces/bonds.h"
#include "clay/forces/potential.h"
#include "clay/kernel.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "clay/range_sums.h"
#include "clay/solver/conjugate_gradients.h"
#include "clay/solver/lump_sums.h"
#include "clay/solver/lumps.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// Our scheme: a time step minimises the incremental potential M/(2 dt^2) |u - free|^2 + energies of the
/// constraints (StepPotential) over the displacements u, subject to contact (class Contacts), by conjugate
/// gradients; see doc/method/clay.md.
class Minimiser {
 public:
  /// @param spacing m
  Minimiser(const Kernel& kernel, double spacing, const std::vector<Material>& materials);

  struct Goal {
    Eigen::Vector3f gravity;  // m/s^2
    int iterations;           // maximum; more only where contacts pulled the clay
    double tolerance;         // m/s^2; the step is solved if no particle lacks more acceleration
  };
  struct Solved {
    int iterations = 0;
    int rounds = 0;         // of iterations; contacts and compression are updated between them
    double setup_ms = 0.0;  // wall time of the setup
  };
  /// Solves a step, as well as the budget allows.
  /// @param contacts as detected; their states, anchors and forces are set
  /// @param u is set to the displacements of the step, m
  Solved solve(const StepInput& in, Contacts& contacts, const Goal& goal, VectorField& u);

  // About the step that was solved last.
  /// Displacements, m, that undo compression for which no work was done. They are to be added to those of the
  /// step, but do not count as velocity. Null: there are none.
  const VectorField* recovery() const { return step_.excessive ? &recovery_ : nullptr; }
  /// rho / rho_0 at the start of the step.
  const std::vector<float>& densityRatio() const { return step_.density.ratio; }
  /// The part of the compression C of a particle that density may give back after the step.
  float compression(const Neighbourhood& near, std::size_t i) const {
    return kept_[near.lump(i)] * paidCompression(step_.density, descent_.compression(), i);
  }

 private:
  struct Step {
    const StepInput& in;
    Contacts& contacts;
    const Goal& goal;
  };
  ConjugateGradients::Step descentOf(const Step& step) const { return {step.in, step_, step.contacts}; }

  void start(const Step& step, VectorField& u);
  int iterate(const Step& step, VectorField& u);
  void translate(const Step& step, VectorField& u);
  static void makeRoom(const Step& step, VectorField& u);
  void balanceForces(const Step& step, const VectorField& u);
  void undoExcess(const Step& step, const VectorField& u);
  // energy_guards.cpp
  bool gainsByPull(const Step& step, double pulled, const VectorField& u);
  void shorten(const Step& step, VectorField& u);
  bool mayGain(const Step& step, const std::vector<bool>& rests, const std::vector<double>& work,
               const VectorField& u);
  void keepCompression(const Step& step);

  Lumps lumps_;
  Potential potential_;
  ConjugateGradients descent_;
  RangeSums energies_;
  LumpSums<3> inertial_forces_;
  LumpSums<1> slopes_, stored_;
  LumpSums<2> slopes_and_motions_;

  // Of the current step.
  StepPotential step_;
  VectorField product_;      // N, A u, if u is shortened
  VectorField recovery_;     // m
  std::vector<float> kept_;  // share of its compression that density may give back, of each lump
};

}  // namespace tactile_clay::clay
