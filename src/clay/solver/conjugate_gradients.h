#pragma once

#include <vector>

#include "clay/contact/contacts.h"
#include "clay/forces/potential.h"
#include "clay/range_sums.h"
#include "clay/solver/coarse_level.h"
#include "clay/solver/lump_sums.h"
#include "clay/solver/lumps.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// Conjugate gradients on the potential of a step, preconditioned by the masses, in the directions that
/// contacts leave free.
///
/// The first direction is the displacements u, without the rigid motions of lumps that no contact blocks. The
/// second is the motion of cubes (CoarseLevel). All other directions are conjugate to these (deflation, Saad
/// et al. 2000), so the residual stays orthogonal to u. Because the energies are convex, a time step then
/// gains no energy, however few iterations it has; see doc/method/clay.md. Lumps do not interact, so each
/// lump has its own step lengths. With common step lengths, a crumb took the energy of a block.
class ConjugateGradients {
 public:
  /// What the functions read of a time step.
  struct Step {
    const StepInput& in;
    const StepPotential& potential;
    const Contacts& contacts;
  };
  /// @param spacing m
  explicit ConjugateGradients(float spacing) : coarse_(spacing) {}

  void begin(const StepInput& in);

  /// Does `count` iterations at most.
  /// @param tolerance m/s^2, see Minimiser::Goal
  /// @param lumps of this step, after Lumps::measure
  /// @param u displacements, m
  /// @return whether no particle lacks more acceleration than `tolerance`
  bool descend(const Step& step, int count, double tolerance, Lumps& lumps, VectorField& u);
  int iterations() const { return iterations_; }  // since `begin`

  /// Finds the residual at the displacements u, forces - M (u - free) / dt^2, N.
  void findResidual(const Step& step, const VectorField& u);
  const VectorField& residual() const { return r_; }
  /// Sets a_x = A x = M x / dt^2 - (linear part of the forces at x), N. The active density constraints are
  /// those of the residual that was found last.
  /// @return for each lump x . A x and x . r
  OfLumps<Sums> multiply(const Step& step, const VectorField& x, VectorField& a_x);

  /// Mass over the square of the time step, N/m, of each particle.
  const std::vector<float>& inertia() const { return inertia_; }
  /// Compression at the displacements that `descend` or `findResidual` reached last.
  const Compression& compression() const { return compression_; }
  Compression& compression() { return compression_; }

 private:
  /// State of the iterations for one lump.
  struct Descent {
    bool active = true;  // whether the iterations go on for it
    double last = 0.0;   // r . z when the last direction was set
    float step = 0.0f;   // step length along the direction
    float again = 0.0f;  // factor of the last direction in the next
    // Of d and w: the products d . A d, and their factors in the next direction.
    double of_d = 0.0, of_w = 0.0;
    float deflation_d = 0.0f, deflation_w = 0.0f;
  };
  /// Runs f(first, last) for ranges of all particles.
  template <typename F>
  void ranges(const F& f) const {
    parallelRanges(inertia_.size(), range_size, f);
  }
  /// Returns for each lump the sum of f(lump, first, last) over its runs.
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
  CoarseLevel::Step coarseOf(const Step& step) const {
    return {step.in, step.potential.pairs, step.contacts, inertia_};
  }
  OfLumps<Sums> moveAsCubes(const Step& step, const OfLumps<Sums>& products, float enough, VectorField& u);
  void setDirection(const Step& step, bool first_one, const OfLumps<Sums>& products, float enough);
  bool findSteps(const OfLumps<Sums>& along, float dt);
  OfLumps<Sums> follow(const Step& step, const VectorField& p, const VectorField& a_p, VectorField& u);
  Sums finishResidual(const Step& step, const VectorField& u, std::size_t first, std::size_t last);
  Sums finishProduct(const Step& step, const VectorField& x, VectorField& a_x, std::size_t first,
                     std::size_t last);
  Sums precondition(const Step& step, std::size_t first, std::size_t last);

  RunSums<Sums> sums_;
  CoarseLevel coarse_;
  // Of the current time step.
  std::vector<float> inertia_;
  Compression compression_;
  VectorField r_, z_, p_, q_;      // residual r, preconditioned residual z, direction p, A p
  VectorField d_, a_d_, w_, a_w_;  // first direction d, A d; second w, A w
  std::vector<Descent> descents_;  // one per lump
  bool cubes_move_ = false;        // whether this round has a direction w
  int iterations_ = 0;
};

}  // namespace tactile_clay::clay
