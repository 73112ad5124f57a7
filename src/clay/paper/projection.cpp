#include "clay/paper/projection.h"

#include <algorithm>
#include <cmath>

#include "clay/lattice.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

constexpr std::size_t grain = 128;  // particles in whole lanes

// Shares of full corrections; each is near the largest with which a block comes to rest.
constexpr float density_relaxation = 0.25f;
constexpr float bond_relaxation = 1.3f;  // over the greater number of bonds of the two ends

std::size_t wholeLanes(std::size_t count) {
  return (count + lane_width - 1) / lane_width * lane_width;
}

/// @param u gets its first three numbers changed
TACTILE_CLAY_INLINE void projectTouch(Projection::Touch& touch, Eigen::Vector4f& u) {
  Eigen::Vector3f moved = u.head<3>();
  const float depth = touch.gap - touch.normal.dot(moved);
  if (!(depth > 0.0f)) return;
  moved += depth * touch.normal;
  Eigen::Vector3f pull = touch.anchor - moved;
  pull -= pull.dot(touch.normal) * touch.normal;
  const float square = pull.squaredNorm(), limit = touch.friction * depth;
  if (square > limit * limit) pull *= limit / std::sqrt(square);
  u.head<3>() = moved + pull;
  touch.pushed += depth;
  touch.pulled += pull;
}

}  // namespace

Projection::Projection(const Kernel& kernel, float spacing, const std::vector<Material>& materials)
    : kernel_(kernel), volume_(spacing * spacing * spacing), lattice_sum_(latticeSum(kernel, spacing)) {
  for (const Material& m : materials) {
    viscosity_.push_back(static_cast<float>(m.viscosity));
    friction_.push_back(static_cast<float>(m.friction));
    skin_friction_.push_back(static_cast<float>(m.skin_friction));
    dense_.push_back(m.bulk_modulus > 0.0);
    any_dense_ = any_dense_ || m.bulk_modulus > 0.0;
    viscous_ = viscous_ || m.viscosity > 0.0;
  }
}

std::vector<Contact> Projection::solve(const StepInput& input, int iterations,
                                       const std::vector<Contact>& contacts, VectorField& u) {
  begin(input);
  beginContacts(input.particles, contacts);
  for (int k = 0; k < iterations; ++k) {
    if (any_dense_) projectDensity();
    if (viscous_) projectViscosity();
    projectBondsAndContacts();
  }
  u.resize(u_.size());
  parallelFor(u.size(), grain, [&](std::size_t i) { u.set(i, u_.at(i)); });
  std::vector<Contact> solved = contacts;
  endContacts(input, solved);
  return solved;
}

void Projection::begin(const StepInput& input) {
  const std::size_t n = input.particles.size(), whole = wholeLanes(n), pairs = input.near.pairs();
  pairs_ = input.near.arrays();
  bonded_ = input.bonds != nullptr && input.bonds->size() > 0;
  ratio_.resize(n);
  u_.resize(n);
  moved_.resize(n);
  inverse_mass_.resize(whole);
  if (any_dense_) {
    density_gradient_.resize(3 * pairs);
    density_share_.resize(whole);
    density_step_.resize(whole);
  }
  if (viscous_) {
    gradient_.resize(3 * pairs);
    own_gradient_.resize(n);
    compliance_.resize(whole);
    viscosities_.resize(whole / lane_width);
    strain_step_xy_.resize(8 * whole);
    strain_step_z_.resize(4 * whole);
  }
  if (bonded_) {
    bond_relaxation_.resize(n);
    bond_end_.resize(n);
    bond_slot_.resize(pairs);
    for (auto* numbers : {&bond_x_, &bond_y_, &bond_z_, &rest_length_, &bond_share_}) numbers->resize(pairs);
  }
  parallelFor(whole, grain, [&](std::size_t i) { beginParticle(input, i); });
  parallelRanges(n, grain, [&](std::size_t first, std::size_t last) {
    paper::measureRatios(pairs_, kernel_, lattice_sum_, first, last, ratio_.data());
    if (viscous_) paper::beginStrains(pairs_, strains(), first, last);
    if (bonded_)
      paper::listBonds(pairs_, input.bonds->restLengths().data(), bond_relaxation_.data(),
                       inverse_mass_.data(), first, last, bondEnds());
  });
}

/// What no pair has part in; beyond the last particle, what lets whole lanes be read.
void Projection::beginParticle(const StepInput& input, std::size_t i) {
  const bool is = i < input.particles.size();
  const std::uint8_t material = is ? input.particles.material[i] : 0;
  inverse_mass_[i] = is ? input.particles.inverse_mass[i] : 0.0f;
  if (any_dense_) density_share_[i] = is && dense_[material] ? density_relaxation : 0.0f;
  if (viscous_) {
    const float viscosity = is ? viscosity_[material] : 0.0f;
    compliance_[i] = viscosity > 0.0f ? 1.0f / (2.0f * viscosity * volume_ * input.dt) : -1.0f;
  }
  if (!is) return;
  u_[i] = input.free[i];
  u_[i][3] = inverse_mass_[i];
  if (bonded_) {
    const auto count = static_cast<float>(input.bonds->end(i) - input.bonds->begin(i));
    bond_relaxation_[i] = std::min(bond_relaxation / std::max(count, 1.0f), 1.0f);
  }
}

void Projection::beginContacts(const Particles& particles, const std::vector<Contact>& contacts) {
  contact_begin_.assign(particles.size() + 1, 0);
  for (const Contact& c : contacts) ++contact_begin_[c.particle + 1];
  for (std::size_t i = 0; i < particles.size(); ++i) contact_begin_[i + 1] += contact_begin_[i];
  touches_.resize(contacts.size());
  parallelFor(contacts.size(), grain, [&](std::size_t k) {
    const Contact& c = contacts[k];
    const float friction =
        (c.solid == Contact::skin ? skin_friction_ : friction_)[particles.material[c.particle]];
    touches_[k] = {c.particle, c.gap, c.normal, c.anchor, friction, 0.0f, Eigen::Vector3f::Zero()};
  });
}

void Projection::projectDensity() {
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    paper::measureDensities(pairs_, densities(), u_.data(), first, last);
  });
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    paper::moveByDensities(pairs_, densities(), first, last, u_.data());
  });
}

void Projection::projectViscosity() {
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    paper::measureStrains(pairs_, strains(), u_.data(), first, last);
  });
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    paper::moveByStrains(pairs_, strains(), first, last, u_.data());
  });
}

void Projection::projectBondsAndContacts() {
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    if (bonded_) {
      paper::pullEnds(pairs_.begin, bondEnds(), u_.data(), first, last, moved_.data());
    } else {
      for (std::size_t i = first; i < last; ++i) moved_[i] = u_[i];
    }
    for (std::uint32_t c = contact_begin_[first]; c < contact_begin_[last]; ++c)
      projectTouch(touches_[c], moved_[touches_[c].particle]);
  });
  std::swap(u_, moved_);
}

/// Sets what the contacts bore. An anchor is left behind by no more than the friction of the step moved the
/// particle.
void Projection::endContacts(const StepInput& input, std::vector<Contact>& contacts) const {
  parallelFor(contacts.size(), grain, [&](std::size_t k) {
    Contact& c = contacts[k];
    const Touch& touch = touches_[k];
    const float force_per_metre = 1.0f / (input.dt * input.dt * input.particles.inverse_mass[c.particle]);
    c.state = touch.pushed > 0.0f ? Contact::State::slide : Contact::State::open;
    c.friction = force_per_metre * touch.pulled;
    c.force = c.friction + force_per_metre * touch.pushed * c.normal;
    c.anchor -= u_.at(c.particle);
    if (c.state == Contact::State::open) return;
    c.anchor = c.along(c.anchor);
    const float distance = c.anchor.norm(), moved = touch.pulled.norm();
    if (distance > moved) c.anchor *= moved / distance;
  });
}

}  // namespace tactile_clay::clay
