#include "clay/forces/potential.h"

#include <atomic>

#include "clay/lattice.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

// Number of particles whose pairs fit into the last-level cache of usual processors. For so few, prefetching
// costs a tenth more time.
constexpr std::size_t few = 1u << 15u;

}  // namespace

/// Adds the forces and densities at u = 0 to those that u alone adds to particles [first, last).
/// @return whether any density constraint is active
bool StepPotential::addStart(VectorField& f, Compression& at, std::size_t first, std::size_t last) const {
  for (std::size_t i = first; i < last; ++i) f[i] += start_force[i];
  return pairs.dense && at.activate(density, first, last);
}

Pressing StepPotential::startForce(const VectorField& u, VectorField& f, Compression& at) const {
  std::atomic<bool> any{false};
  parallelRanges(f.size(), range_size, [&](std::size_t first, std::size_t last) {
    stretchPairs(pairs, {u.data(), f.data(), at.c.data()}, first, last);
    if (addStart(f, at, first, last)) any = true;
  });
  at.pressing = any;
  return {pairs, {at.pressure.data(), f.data()}, {}, at.squeezed.data(), true, at.pressing};
}

Pressing StepPotential::startChange(const VectorField& p, VectorField& change, Compression& at) const {
  parallelRanges(change.size(), range_size, [&](std::size_t first, std::size_t last) {
    stretchPairs(pairs, {p.data(), change.data(), at.growth.data()}, first, last);
    if (at.pressing) at.changePressure(first, last);
  });
  return {pairs, {at.pressure_change.data(), change.data()}, {}, at.squeezed.data(), false, at.pressing};
}

Pressing StepPotential::startForceAndChange(const VectorField& u, VectorField& f, const VectorField& p,
                                            VectorField& change, Compression& at) const {
  std::atomic<bool> any{false};
  parallelRanges(f.size(), range_size, [&](std::size_t first, std::size_t last) {
    stretchPairs(pairs, {u.data(), f.data(), at.c.data()}, {p.data(), change.data(), at.growth.data()}, first,
                 last);
    if (addStart(f, at, first, last)) any = true;
    if (pairs.dense) at.changePressure(first, last);
  });
  at.pressing = any;
  const Press force{at.pressure.data(), f.data()}, its_change{at.pressure_change.data(), change.data()};
  return {pairs, force, its_change, at.squeezed.data(), true, at.pressing};
}

Potential::Potential(const Kernel& kernel, float spacing, const std::vector<Material>& materials)
    : kernel_(kernel),
      spacing_(spacing),
      lattice_sum_(latticeSum(kernel, spacing)),
      lattice_dashpots_(static_cast<float>(latticeDashpots(kernel, spacing))),
      materials_(materials.size()),
      boundary_(kernel, spacing, materials) {
  const float volume = spacing * spacing * spacing;
  for (const Material& a : materials) {
    bulks_.push_back(static_cast<float>(a.bulk_modulus) * volume);
    flow_indices_.push_back(static_cast<float>(a.flow_index));
    thins_ = thins_ || (a.flow_index < 1.0 && a.viscosity > 0.0);
    dense_ = dense_ || a.bulk_modulus > 0.0;
    for (const Material& b : materials) {
      // Two materials act like two layers in shear, whose compliances add up.
      const double both = a.viscosity + b.viscosity;
      const double eta = both > 0.0 ? 2.0 * a.viscosity * b.viscosity / both : 0.0;
      // Springs along pairs have the shear modulus sum_j k r^2 / (30 V), averaged over directions.
      dashpots_.push_back(static_cast<float>(30.0 * volume * eta / lattice_dashpots_));
      viscous_ = viscous_ || eta > 0.0;
    }
  }
}

/// Resizes the arrays that a step uses. Arrays that it does not use stay empty.
void Potential::resize(const StepInput& input, StepPotential& s) {
  const Neighbourhood& near = input.near;
  const std::size_t n = input.particles.size();
  const bool sprung = viscous_ || input.bonds != nullptr;
  DensityConstraints& d = s.density;
  for (auto* numbers : {&d.ratio, &d.excess, &d.steepness, &amend_}) numbers->resize(n);
  if (dense_) {
    for (auto* numbers : {&d.bulk, &d.stiffness, &d.lent, &d.beyond}) numbers->resize(n);
    for (auto* numbers : {&s.gradient_x, &s.gradient_y, &s.gradient_z}) numbers->resize(near.pairs());
  }
  if (dense_ || sprung) s.spring.resize(near.pairs());
  s.start_force.resize(n);
  s.half_spacing = 0.5f * spacing_;
  s.dt = input.dt;
  s.pairs = {near.arrays(), s.spring.data(), dense_, sprung, n > few};
  if (dense_) {
    s.pairs.x = s.gradient_x.data();
    s.pairs.y = s.gradient_y.data();
    s.pairs.z = s.gradient_z.data();
  }
  dashpots_of_step_.clear();
  for (const float dashpot : dashpots_) dashpots_of_step_.push_back(dashpot / input.dt);
}

Setup Potential::setupOf(const StepInput& input, StepPotential& s) {
  const Bonds* const bonds = input.bonds;
  const float* const rest_lengths = bonds != nullptr ? bonds->restLengths().data() : nullptr;
  const float* const thinning = thins_ ? flow_indices_.data() : nullptr;
  return {input.near.arrays(),
          input.free.data(),
          input.particles.material.data(),
          materials_,
          {bonds, rest_lengths, s.secants.value.data(), s.secants.change.data()},
          {viscous_, dashpots_of_step_.data(), thinning, lattice_dashpots_, input.dt},
          kernel_,
          lattice_sum_,
          dense_,
          s.pairs.sprung,
          {s.gradient_x.data(), s.gradient_y.data(), s.gradient_z.data(), s.spring.data()},
          s.density.ratio.data(),
          s.density.steepness.data(),
          s.density.excess.data(),
          amend_.data(),
          s.start_force.data()};
}

void Potential::linearise(const StepInput& input, const std::vector<Contact>& contacts, StepPotential& step) {
  resize(input, step);
  const std::size_t n = input.particles.size();
  if (input.bonds != nullptr) step.secants.value = input.bonds->flow().secant;
  const Setup setup = setupOf(input, step);
  parallelRanges(n, range_size,
                 [&](std::size_t first, std::size_t last) { measureSurroundings(setup, first, last); });
  parallelRanges(n, range_size,
                 [&](std::size_t first, std::size_t last) { linearisePairs(setup, first, last); });
  std::atomic<bool> excessive{false};
  if (dense_) {
    DensityConstraints& d = step.density;
    for (const BoundaryDensity::Share& share : boundary_.update(input.particles, d.ratio, contacts)) {
      d.ratio[share.particle] += share.ratio;
      d.excess[share.particle] += share.ratio;
    }
    parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) d.bulk[i] = bulks_[input.particles.material[i]];
      if (boundExcess(input.particles, first, last, d)) excessive = true;
    });
  }
  step.excessive = excessive;
}

void Potential::yieldAt(const VectorField& u, const StepInput& input, const std::vector<Contact>& contacts,
                        StepPotential& step) {
  if (input.bonds == nullptr) return;
  step.secants.change.resize(step.secants.value.size());
  const std::size_t n = input.particles.size();
  const Setup setup = setupOf(input, step);
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    measureSecants(input, contacts, u, first, last, step.secants);
  });
  parallelRanges(n, range_size,
                 [&](std::size_t first, std::size_t last) { changeSecants(setup, first, last); });
}

}  // namespace tactile_clay::clay
