#pragma once

#include <vector>

#include "clay/contact/contacts.h"
#include "clay/forces/potential.h"
#include "clay/range_sums.h"
#include "clay/solver/lump_sums.h"
#include "clay/solver/lumps.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// Conjugate gradients on the potential of a step, preconditioned by the masses, in the directions that
/// contacts leave free.
///
/// The first direction is that of the displacements themselves, and all others are conjugate to it
/// (deflation, Saad et al. 2000): the residual stays orthogonal to the displacements, and so, the energies
/// being convex, a step gains no energy however few directions are tried; see doc/method/clay.md.
/// Lumps do not interact, so each has steps of its own: with common ones a crumb took the energy of a block.
class ConjugateGradients {
 public:
  /// What a step is made of.
  struct Step {
    const StepInput& in;
    const StepPotential& potential;
    const Contacts& contacts;
  };
  void begin(const StepInput& in);

  /// Does `count` iterations at most.
  /// @param tolerance m/s^2, see Minimiser::Goal
  /// @param lumps as measured
  /// @param u displacements, m
  /// @return whether no particle lacks more acceleration than that
  bool descend(const Step& step, int count, double tolerance, Lumps& lumps, VectorField& u);
  int iterations() const { return iterations_; }  // in the step

  /// Residual at the displacements u, forces - M (u - free) / dt^2, N.
  void findResidual(const Step& step, const VectorField& u);
  const VectorField& residual() const { return r_; }
  /// a_x = A x = M x / dt^2 - (linear part of the forces), N, from the residual that was last found.
  /// @return of each lump, x . A x, and x . r
  OfLumps<Sums> multiply(const Step& step, const VectorField& x, VectorField& a_x);

  /// N/m, of each particle, its mass over the square of the time step.
  const std::vector<float>& inertia() const { return inertia_; }
  /// At the displacements that were last come to.
  const Compression& compression() const { return compression_; }
  Compression& compression() { return compression_; }

 private:
  /// Where a lump is.
  struct Descent {
    bool active = true;                    // whether its residual is to be lowered
    double own = 0.0;                      // d . A d
    double last = 0.0;                     // r . z at the last direction
    float step = 0.0f;                     // along the direction
    float again = 0.0f, deflation = 0.0f;  // of the last direction, and of d, in the next
  };
  /// Runs f(first, last) over the particles.
  template <typename F>
  void ranges(const F& f) const {
    parallelRanges(inertia_.size(), range_size, f);
  }
  /// Of each lump, what f(lump, first, last) gives over its runs.
  template <typename F>
  OfLumps<Sums> sumOver(const Step& step, const F& f) {
    return sums_.of(step.in.near, inertia_.size(), Sums(), f);
  }
  void setOwnDirection(const Step& step, const Lumps& lumps, const std::vector<Lumps::Unblocked>& motions,
                       const VectorField& u);
  OfLumps<Sums> residualBesideOwnProduct(const Step& step, const VectorField& u);
  OfLumps<Sums> moveAsLumps(const Step& step, Lumps& lumps, std::vector<Lumps::Unblocked>& motions,
                            VectorField& u);
  void startDescents(const OfLumps<Sums>& own);
  void setDirection(const Step& step, bool first_one, const OfLumps<Sums>& products, float enough);
  bool findSteps(const OfLumps<Sums>& along, float dt);
  OfLumps<Sums> follow(const Step& step, const VectorField& p, const VectorField& a_p, VectorField& u);
  Sums finishResidual(const Step& step, const VectorField& u, std::size_t first, std::size_t last);
  Sums finishProduct(const Step& step, const VectorField& x, VectorField& a_x, std::size_t first,
                     std::size_t last);
  Sums precondition(const Step& step, std::size_t first, std::size_t last);

  RunSums<Sums> sums_;
  // Of the step.
  std::vector<float> inertia_;
  Compression compression_;
  VectorField r_, z_, p_, q_;      // residual, preconditioned residual, direction, its product
  VectorField d_, a_d_;            // direction of the displacements themselves, its product
  std::vector<Descent> descents_;  // of the lumps
  int iterations_ = 0;
};

}  // namespace tactile_clay::clay
