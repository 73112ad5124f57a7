#include "clay/contact/contacts.h"

#include <algorithm>
#include <cmath>

namespace tactile_clay::clay {
namespace {

constexpr float pre_sliding = 0.01f;  // spacings, by which a friction spring gives before its contact slides
// Stiffness of friction springs, in particle masses per step^2. Softer springs would let a light load creep.
// If springs are much stiffer than inertia, conjugate gradients need more iterations than there are.
constexpr float min_stiffness = 20.0f, max_stiffness = 500.0f;

using Vector = Eigen::Vector3f;

bool isBefore(const Contact& a, std::uint32_t particle) {
  return a.particle < particle;
}

}  // namespace

Contacts::Contacts(float spacing, const std::vector<Material>& materials)
    : spacing_(spacing), colliders_(spacing), search_(spacing) {
  for (const Material& m : materials) {
    friction_.push_back(static_cast<float>(m.friction));
    skin_friction_.push_back(static_cast<float>(m.skin_friction));
    adhesion_.push_back(static_cast<float>(m.adhesion) * spacing * spacing);
  }
}

float Contacts::friction(const Contact& c, const Particles& particles) const {
  const auto& of_material = c.solid == Contact::skin ? skin_friction_ : friction_;
  return of_material[particles.material[c.particle]];
}

/// Pull that a contact resists without load, N.
float Contacts::adhesion(const Contact& c, const Particles& particles) const {
  return c.solid == Contact::skin ? 0.0f : adhesion_[particles.material[c.particle]];
}

void Contacts::detect(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
                      const Surroundings& around) {
  looks_ = 0;
  previous_.swap(contacts_);
  colliders_.begin(around);
  ContactSearch::Found& found = search_.findAtStart(previous_, near, particles, guess, colliders_, around.dt);
  contacts_.resize(found.contacts.size());
  shares_.swap(found.shares);
  parallelRanges(contacts_.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t c = first; c < last; ++c) contacts_[c] = opened(found.contacts[c], particles, around.dt);
    recall(guess, first, last);
  });
  listFilters();
}

/// Makes a contact of a newly found place: it is open and has no past.
Contact Contacts::opened(const ContactGeometry& found, const Particles& particles, float dt) const {
  Contact c;
  static_cast<ContactGeometry&>(c) = found;
  c.anchor = c.drift;
  if (friction(c, particles) > 0.0f)
    c.stiffness = min_stiffness / (particles.inverse_mass[c.particle] * dt * dt);
  return c;
}

/// Takes over the states that contacts [first, last) had in the step before.
void Contacts::recall(const VectorField& guess, std::size_t first, std::size_t last) {
  auto from = std::lower_bound(previous_.cbegin(), previous_.cend(), contacts_[first].particle, isBefore);
  for (std::size_t k = first; k < last; ++k) {
    Contact& c = contacts_[k];
    while (from != previous_.cend() && from->particle < c.particle) ++from;
    for (auto old = from; old != previous_.cend() && old->particle == c.particle; ++old) {
      if (old->state == Contact::State::open || old->solid != c.solid ||
          old->normal.dot(c.normal) <= Contact::same_side)
        continue;
      c.state = old->state;
      c.stiffness = old->stiffness;
      c.density = old->density;
      c.anchor = old->anchor + c.drift;
      c.friction = c.along(old->friction);
      // Friction that no longer opposes the motion would push.
      if (c.state == Contact::State::slide && !(c.friction.dot(guess.at(c.particle) - c.drift) < 0.0f))
        c.state = Contact::State::stick;
      break;
    }
  }
}

void Contacts::listFilters() {
  filters_.clear();
  for (std::uint32_t c = 0; c < contacts_.size(); ++c) {
    if (filters_.empty() || filters_.back().particle != contacts_[c].particle)
      filters_.push_back({contacts_[c].particle, c, c + 1, 0, 0.0f, Eigen::Matrix3f::Identity()});
    else
      filters_.back().last = c + 1;
  }
}

bool Contacts::detectStrays(const Particles& particles, const VectorField& u, float dt) {
  const ContactSearch::Found& strays = search_.findStrays(particles, colliders_, u, dt);
  const std::size_t led_to = contacts_.size();
  bool turned = false;
  for (const ContactGeometry& stray : strays.contacts) {
    Contact* same = known(stray);
    if (same == nullptr) {
      const auto first = strays.shares.begin() + stray.first_sample;
      contacts_.push_back(opened(stray, particles, dt));
      contacts_.back().first_sample = static_cast<std::uint32_t>(shares_.size());
      shares_.insert(shares_.end(), first, first + stray.sample_count);
    } else if (stray.solid == Contact::skin) {
      same->normal = stray.normal;
      same->gap = stray.gap;
      same->friction = stray.along(same->friction);
      turned = true;
    }
  }
  if (contacts_.size() == led_to) return turned;
  std::stable_sort(contacts_.begin(), contacts_.end(),
                   [](const Contact& a, const Contact& b) { return a.particle < b.particle; });
  listFilters();
  return true;
}

/// The contact of the same particle with the same solid or the same side of the skin, among the contacts at
/// the last sort. Null: there is none.
Contact* Contacts::known(const ContactGeometry& found) {
  Contact* same = nullptr;
  forFilters(found.particle, found.particle + 1, [&](const Filter& f) {
    for (Contact& c : of(f))
      if (c.solid == found.solid &&
          (c.solid != Contact::skin || c.normal.dot(found.normal) > Contact::same_side))
        same = &c;
  });
  return same;
}

void Contacts::remember(const std::vector<BoundaryDensity::Share>& shares) {
  for (const BoundaryDensity::Share& share : shares)
    forFilters(share.particle, share.particle + 1, [&](const Filter& f) {
      for (Contact& c : of(f)) c.density = share.ratio;
    });
}

void Contacts::finish(const Particles& particles, float dt) {
  forEach(filters_.size(), [&](std::size_t f) {
    const float unit = 1.0f / (particles.inverse_mass[filters_[f].particle] * dt * dt);
    for (Contact& c : of(filters_[f])) {
      if (!(c.stiffness > 0.0f)) continue;
      // The stiffness goes half the way to the one that the next step's load asks for. A stiffness that
      // followed a trembling force at once would feed the trembling.
      const float limit = friction(c, particles) * (c.force.dot(c.normal) + adhesion(c, particles));
      c.stiffness = std::clamp(0.5f * (c.stiffness + limit / (pre_sliding * spacing_)), min_stiffness * unit,
                               max_stiffness * unit);
      const float maximum = std::sqrt(2.0f * c.paid / c.stiffness), length = c.friction.norm() / c.stiffness;
      c.anchor = std::min(maximum / std::max(length, 1e-30f), 1.0f) / c.stiffness * c.friction;
    }
  });
}

}  // namespace tactile_clay::clay
