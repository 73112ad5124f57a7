#include <algorithm>
#include <atomic>
#include <cmath>

#include "clay/contact/contacts.h"

namespace tactile_clay::clay {
namespace {

constexpr float detour = 2.0f;  // spacings, by which a way may be longer than the depth of the contact
// Share of a normal; if earlier contacts leave less of it free, the normal is not prescribed.
constexpr float min_free = 0.3f;
constexpr float max_damping = 500.0f;  // particle masses per step^2, of sliding; as of the stiffest spring

using Vector = Eigen::Vector3f;

}  // namespace

Eigen::Vector3f Contacts::prescribed(Filter& filter, Vector u) {
  filter.rank = 0;
  filter.free.setIdentity();
  for (Contact& c : of(filter)) {
    if (c.state == Contact::State::open) {
      if (c.normal.dot(u) >= c.gap) continue;
      // Its normal force, and so its maximum friction, is not known yet.
      c.state = Contact::State::slide;
    }
    // Only what earlier contacts of the particle leave free can be prescribed.
    const Vector left = filter.free * c.normal;
    const float size = left.norm();
    if (filter.rank == 3 || size < min_free) continue;
    const Vector q = left / size;
    const float way = c.depth(u);
    // Between two contacts that almost face each other the way is longer than the depth. If it is much
    // longer, it is no solution.
    if (std::abs(way) / size > std::abs(way) + detour * spacing_) continue;
    u += way / size * q;
    filter.free -= q * q.transpose();
    ++filter.rank;
  }
  if (filter.rank == 3) filter.free.setZero();
  return u;
}

void Contacts::prescribe(VectorField& u) {
  forEach(filters_.size(), [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    u.set(i, prescribed(filters_[f], u.at(i)));
  });
}

void Contacts::close(const std::vector<std::uint32_t>& which) {
  for (const std::uint32_t c : which) contacts_[c].state = Contact::State::slide;
}

void Contacts::filter(std::size_t first, std::size_t last, VectorField& field) const {
  forFilters(first, last, [&](const Filter& f) {
    if (f.rank > 0) field.set(f.particle, f.free * field.at(f.particle));
  });
}

void Contacts::dampSlides(const Particles& particles, const VectorField& u, float dt) {
  forEach(filters_.size(), [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    const float maximum = max_damping / (particles.inverse_mass[i] * dt * dt);
    for (Contact& c : of(filters_[f])) {
      const float force = c.friction.norm(), slip = c.along(u.at(i) - c.drift).norm();
      if (c.state == Contact::State::slide && force > 0.0f)
        c.damping = force < maximum * slip ? force / slip : maximum;
    }
  });
}

Eigen::Vector3f springPull(const Contact& c, const Vector& u) {
  return c.stiffness * c.along(c.anchor - u);
}

Eigen::Vector3f frictionOn(const Contact& c, const Vector& u) {
  switch (c.state) {
    case Contact::State::slide:
      return c.damping > 0.0f ? Vector(-c.damping * c.along(u - c.drift)) : c.friction;
    case Contact::State::stick:
      return springPull(c, u);
    case Contact::State::open:
      break;
  }
  return Vector::Zero();
}

void Contacts::addFriction(const VectorField& u, std::size_t first, std::size_t last,
                           VectorField& force) const {
  forFilters(first, last, [&](const Filter& f) {
    for (const Contact& c : of(f)) force.add(f.particle, frictionOn(c, u.at(f.particle)));
  });
}

void Contacts::listHeld(std::vector<std::uint32_t>& particles) const {
  particles.clear();
  for (const Filter& f : filters_) {
    const auto contacts = of(f);
    if (std::any_of(contacts.begin(), contacts.end(),
                    [](const Contact& c) { return c.state != Contact::State::open; }))
      particles.push_back(f.particle);
  }
}

void Contacts::addFrictionChange(const VectorField& p, std::size_t first, std::size_t last,
                                 VectorField& force) const {
  forFilters(first, last, [&](const Filter& f) {
    for (const Contact& c : of(f)) {
      if (c.state == Contact::State::open) continue;
      const float resistance = c.state == Contact::State::stick ? c.stiffness : c.damping;
      force.add(f.particle, -resistance * c.along(p.at(f.particle)));
    }
  });
}

Contacts::Changes Contacts::update(const Particles& particles, const VectorField& u,
                                   const VectorField& residual) {
  std::atomic<bool> changed{false};
  forEach(filters_.size(), [&](std::size_t k) {
    Filter& filter = filters_[k];
    const Vector way = u.at(filter.particle), lacking = residual.at(filter.particle);
    filter.pulled = 0.0f;
    // Force that the contacts must add so that the particle moves as prescribed.
    Vector needed = filter.free * lacking - lacking;
    // The same without the friction on the particle. If two colliders slide on it, the friction of each would
    // raise the normal force of the other, and so the friction of the other, without end.
    Vector loaded = needed;
    if (filter.last > filter.first + 1) {
      for (const Contact& c : of(filter)) loaded += frictionOn(c, way);
      loaded -= filter.free * loaded;
    }
    for (Contact& c : of(filter)) {
      c.force.setZero();
      if (c.state == Contact::State::open) {
        if (c.normal.dot(way) < c.gap) changed = true;
        continue;
      }
      const float pressing = needed.dot(c.normal);
      needed -= pressing * c.normal;
      const float load = loaded.dot(c.normal);
      loaded -= load * c.normal;
      if (update(c, particles, way, pressing, load)) changed = true;
      if (c.state == Contact::State::open && c.gap < 0.0f && c.solid != Contact::skin)
        filter.pulled += pressing * c.gap;
    }
  });
  Changes changes;
  changes.any = changed;
  for (const Filter& filter : filters_) changes.pulled += filter.pulled;
  return changes;
}

/// Reads off the force of a closed contact at the displacement u, and changes its state.
/// @param pressing N, along the normal
/// @param load N, the same without the friction on the particle; the smaller of both counts for friction
/// @return whether the contact acts differently from now on
bool Contacts::update(Contact& c, const Particles& particles, const Vector& u, float pressing, float load) {
  // The force is the one that acted in this round, also if it pulled. The new state acts in the next round.
  const Vector trial = springPull(c, u), rubbing = frictionOn(c, u), slip = c.along(u - c.drift);
  c.force = pressing * c.normal + rubbing;
  c.paid = c.state == Contact::State::stick ? 0.5f * trial.dot(c.along(c.anchor - u))
                                            : 0.5f * c.stiffness * c.along(c.anchor - c.drift).squaredNorm() +
                                                  std::max(-rubbing.dot(slip), 0.0f);
  c.damping = 0.0f;
  if (pressing < -adhesion(c, particles)) {
    c.state = Contact::State::open;
    c.friction.setZero();
    return true;
  }
  const float holding = std::min(pressing, load) + adhesion(c, particles);
  const float limit = friction(c, particles) * std::max(holding, 0.0f), size = trial.norm();
  // A particle that friction would turn around comes to rest first.
  const bool slid = c.state == Contact::State::slide, turned = slid && trial.dot(c.friction) < 0.0f;
  const bool slides = size > limit && !turned;
  c.state = slides ? Contact::State::slide : Contact::State::stick;
  c.friction = size > limit ? Vector(limit / size * trial) : trial;
  return slides || slid;  // its friction has changed
}

void Contacts::balance(const Neighbourhood& near, std::vector<Eigen::Vector3d> total) {
  std::vector<double> force(total.size(), 0.0);
  for (const Contact& c : contacts_) {
    total[near.lump(c.particle)] -= c.force.cast<double>();
    force[near.lump(c.particle)] += c.force.norm();
  }
  for (Contact& c : contacts_) {
    const std::uint32_t lump = near.lump(c.particle);
    if (force[lump] > 0.0) c.force += (c.force.norm() / force[lump] * total[lump]).cast<float>();
  }
}

}  // namespace tactile_clay::clay
