#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/bonds.h"
#include "clay/boundary_density.h"
#include "clay/contacts.h"
#include "clay/kernel.h"
#include "clay/lump_sums.h"
#include "clay/lumps.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "clay/potential.h"
#include "clay/range_sums.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// Our scheme: a time step minimises the incremental potential M/(2 dt^2) |u - free|^2 + energies of the
/// constraints (class Potential) over the displacements u, subject to contact (class Contacts), by conjugate
/// gradients; see doc/method/clay.md.
class Minimiser {
 public:
  /// The neighbourhood and the particles must outlive it. \param spacing m
  Minimiser(const Neighbourhood& near, const Particles& particles, const Kernel& kernel, double spacing,
            const std::vector<Material>& materials);

  /// Sets up a step. \param bonds null: there are none; \param free displacements, m, that the particles
  /// would make without internal and contact forces; \param contacts as detected. All must stay until it is
  /// solved.
  void begin(const Bonds* bonds, const VectorField& free, Contacts& contacts, float dt);

  /// Solves it, as well as the budget allows. Contacts get their states, anchors and forces.
  /// \param gravity m/s^2 \param iterations at most, but where contacts pulled the clay \param tolerance
  /// m/s^2; done where no particle lacks more acceleration \param u displacements of the step, m \return
  /// iterations done
  int solve(const Eigen::Vector3f& gravity, int iterations, double tolerance, VectorField& u);

  /// In the last solution: between them contacts and compression were looked at anew.
  int rounds() const { return rounds_; }

  /// Displacements, m, that undo compression which nothing did work for: to be added to those of the step,
  /// but not to be taken for motion. Null: there is none.
  const VectorField* recovery() const { return beyond_ ? &recovery_ : nullptr; }

  /// rho / rho_0 at the start of the step.
  const std::vector<float>& densityRatio() const { return potential_.densityRatio(); }
  /// What density may give back of the compression of a particle after the step.
  float compression(std::size_t i) const { return kept_[near_.lump(i)] * potential_.paidCompression(i); }

 private:
  /// Runs f(first, last) over the particles.
  template <typename F>
  void ranges(const F& f) const {
    parallelRanges(particles_.size(), range_size, f);
  }
  /// The same over their runs of one lump: f(lump, first, last).
  template <typename F>
  void runs(const F& f) const {
    ranges([&](std::size_t first, std::size_t last) { forRuns(near_, first, last, f); });
  }
  /// Of each lump, what f(lump, first, last) gives over its runs. \return valid until the next call
  template <typename F>
  const std::vector<Sums>& sumOver(const F& f) {
    return sums_.of(near_, particles_.size(), Sums(), f);
  }
  /// Where the conjugate gradients of a lump are.
  struct Descent {
    bool active = false;                   // whether its residual is to be lowered
    double own = 0.0;                      // d . A d
    double last = 0.0;                     // r . z at the last direction
    float step = 0.0f;                     // along the direction
    float again = 0.0f, deflation = 0.0f;  // of the last direction, and of d, in the next
  };
  bool gainsByPull(double pulled, const Eigen::Vector3f& gravity, const VectorField& u);
  void start(const Eigen::Vector3f& gravity, VectorField& u);
  void translate(VectorField& u);
  bool descend(int count, double tolerance, VectorField& u);
  void residual(const VectorField& u);
  const std::vector<Sums>& residualBesideOwnProduct(const VectorField& u);
  Sums finishResidual(const VectorField& u, std::size_t first, std::size_t last);
  void setOwnDirection(const std::vector<Lumps::Unblocked>& motions, const VectorField& u);
  const std::vector<Sums>& moveAsLumps(std::vector<Lumps::Unblocked>& motions, VectorField& u);
  Sums precondition(std::size_t first, std::size_t last);
  const std::vector<Sums>& multiply(const VectorField& x, VectorField& a_x);
  Sums finishProduct(const VectorField& x, VectorField& a_x, std::size_t first, std::size_t last);
  void shorten(VectorField& u);
  bool mayGain(const std::vector<bool>& rests, const std::vector<double>& work, const VectorField& u);
  void balanceForces(const VectorField& u);
  void keepCompression();

  const Neighbourhood& near_;
  const Particles& particles_;
  Lumps lumps_;
  Potential potential_;
  BoundaryDensity boundary_;
  RunSums<Sums> sums_;
  RangeSums energies_;
  LumpSums<3> inertial_forces_;
  LumpSums<1> slopes_, stored_;
  LumpSums<2> slopes_and_motions_;

  // Of the step.
  const VectorField* free_ = nullptr;
  Contacts* contacts_ = nullptr;
  float dt_ = 0.0f;                // s
  std::vector<float> inertia_;     // N/m, mass over the square of the time step
  VectorField r_, z_, p_, q_;      // residual, preconditioned residual, direction, its product
  VectorField d_, a_d_;            // direction of the displacements themselves, its product
  VectorField recovery_;           // m
  std::vector<Descent> descents_;  // of the lumps
  std::vector<float> kept_;        // of each lump, share of the compression that density may give back
  bool beyond_ = false;            // whether there is compression to recover from
  int iterations_done_ = 0, rounds_ = 0;
};

}  // namespace tactile_clay::clay
