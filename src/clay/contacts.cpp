#include "clay/contacts.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

constexpr float pre_sliding = 0.01f;  // spacings, by which a friction spring gives before its contact slides
constexpr float farthest = 6.0f;      // spacings, that what is between skins is pushed out by
constexpr float detour = 2.0f;        // spacings, that a contact may lead a particle beyond its depth
constexpr float plane = 0.25f;        // spacings, over which the skin is one
constexpr float narrow = 0.1f;        // spacings, between skin and centres where there is hardly any room
constexpr float rounding = 1e-3f;     // spacings
constexpr float least_stiffness = 20.0f, most_stiffness = 500.0f;  // its range, particle masses per step^2

using Vector = Eigen::Vector3f;

Vector tangential(const Vector& v, const Vector& n) {
  return v - v.dot(n) * n;
}

/// m, by which a contact is violated at the displacement u.
float depth(const Contact& c, const Vector& u) {
  return c.gap - c.normal.dot(u);
}

}  // namespace

Contacts::Contacts(float spacing, const std::vector<Material>& materials)
    : spacing_(spacing), obstacles_(spacing), search_(spacing) {
  for (const Material& m : materials) {
    friction_.push_back(static_cast<float>(m.friction));
    skin_friction_.push_back(static_cast<float>(m.skin_friction));
    adhesion_.push_back(static_cast<float>(m.adhesion) * spacing * spacing);
  }
}

void Contacts::detect(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
                      const Ghosts& ghosts, const std::vector<Solid>& solids,
                      const std::vector<Eigen::Isometry3d>& start, const std::vector<Eigen::Isometry3d>& end,
                      float dt) {
  looks_ = 0;
  previous_.swap(contacts_);
  obstacles_.begin(ghosts, solids, start, end, dt);
  ContactSearch::Found& found = search_.findAtStart(previous_, near, particles, guess, obstacles_, dt);
  contacts_.swap(found.contacts), shares_.swap(found.shares);
  parallelRanges(contacts_.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t c = first; c < last; ++c) open(contacts_[c], particles, dt);
    recall(guess, first, last);
  });
  listFilters();
}

/// A contact that was found is open and has no past.
void Contacts::open(Contact& found, const Particles& particles, float dt) const {
  found.anchor = found.drift;
  found.stiffness = leastStiffness(found, particles, dt);
}

void Contacts::listFilters() {
  filters_.clear();
  for (std::uint32_t c = 0; c < contacts_.size(); ++c) {
    if (filters_.empty() || filters_.back().particle != contacts_[c].particle) {
      filters_.push_back({contacts_[c].particle, c, c + 1, 0, 0.0f, Eigen::Matrix3f::Identity()});
    } else {
      filters_.back().last = c + 1;
    }
  }
}

template <typename F>
void Contacts::forFilters(std::size_t first, std::size_t last, const F& f) const {
  auto at = std::lower_bound(filters_.begin(), filters_.end(), first,
                             [](const Filter& a, std::size_t particle) { return a.particle < particle; });
  for (; at != filters_.end() && at->particle < last; ++at) f(*at);
}

bool Contacts::detectStrays(const Particles& particles, const VectorField& u, float dt) {
  const ContactSearch::Found& strays = search_.findStrays(particles, obstacles_, u, dt);
  const std::size_t led_to = contacts_.size();
  bool turned = false;
  for (const Contact& stray : strays.contacts) {
    Contact* same = known(stray);
    if (same == nullptr) {
      const auto first = strays.shares.begin() + stray.first_ghost;
      contacts_.push_back(stray);
      contacts_.back().first_ghost = static_cast<std::uint32_t>(shares_.size());
      open(contacts_.back(), particles, dt);
      shares_.insert(shares_.end(), first, first + stray.ghost_count);
    } else if (stray.solid == Contact::skin) {
      same->normal = stray.normal, same->gap = stray.gap;
      same->friction = tangential(same->friction, stray.normal);
      turned = true;
    }
  }
  if (contacts_.size() == led_to) return turned;
  std::stable_sort(contacts_.begin(), contacts_.end(),
                   [](const Contact& a, const Contact& b) { return a.particle < b.particle; });
  listFilters();
  return true;
}

/// The contact of the same particle with the same solid, or the same side of the skin, as of the last sort;
/// null: there is none.
Contact* Contacts::known(const Contact& found) {
  Contact* same = nullptr;
  forFilters(found.particle, found.particle + 1, [&](const Filter& f) {
    for (std::uint32_t k = f.first; k < f.last; ++k) {
      Contact& c = contacts_[k];
      if (c.solid != found.solid) continue;
      if (c.solid != Contact::skin || c.normal.dot(found.normal) > Contact::same_side) same = &c;
    }
  });
  return same;
}

float Contacts::friction(const Contact& c, const Particles& particles) const {
  const auto& of_material = c.solid == Contact::skin ? skin_friction_ : friction_;
  return of_material[particles.material[c.particle]];
}

/// N, that a contact holds with without load.
float Contacts::adhesion(const Contact& c, const Particles& particles) const {
  return c.solid == Contact::skin ? 0.0f : adhesion_[particles.material[c.particle]];
}

/// N/m, what the friction spring of a new contact starts with; 0: there is no friction.
float Contacts::leastStiffness(const Contact& c, const Particles& particles, float dt) const {
  if (!(friction(c, particles) > 0.0f)) return 0.0f;
  return least_stiffness / (particles.inverse_mass[c.particle] * dt * dt);
}

/// What contacts [first, last) were in the step before.
void Contacts::recall(const VectorField& guess, std::size_t first, std::size_t last) {
  auto from =
      std::lower_bound(previous_.cbegin(), previous_.cend(), contacts_[first].particle,
                       [](const Contact& a, std::uint32_t particle) { return a.particle < particle; });
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
      c.friction = tangential(old->friction, c.normal);
      // What no longer opposes the motion would push.
      if (c.state == Contact::State::slide && !(c.friction.dot(guess.at(c.particle) - c.drift) < 0.0f))
        c.state = Contact::State::stick;
      break;
    }
  }
}

Eigen::Vector3f Contacts::prescribed(Filter& filter, Vector u) {
  filter.rank = 0;
  filter.free.setIdentity();
  for (std::uint32_t k = filter.first; k < filter.last; ++k) {
    Contact& c = contacts_[k];
    if (c.state == Contact::State::open) {
      if (c.normal.dot(u) >= c.gap) continue;
      c.state = Contact::State::slide;  // how hard it presses, and so how well it holds, is not known yet
    }
    // Only what earlier contacts of the particle leave free can be prescribed.
    const Vector left = filter.free * c.normal;
    const float size = left.norm();
    if (filter.rank == 3 || size < 0.3f) continue;
    const Vector q = left / size;
    const float way = depth(c, u);
    // Between two that all but face each other the way is longer than deep: no solution, if by much.
    if (std::abs(way) / size > std::abs(way) + detour * spacing_) continue;
    u += way / size * q;
    filter.free -= q * q.transpose();
    ++filter.rank;
  }
  if (filter.rank == 3) filter.free.setZero();
  return u;
}

void Contacts::prescribe(VectorField& u) {
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    u.set(i, prescribed(filters_[f], u.at(i)));
  });
}

void Contacts::filter(std::size_t first, std::size_t last, VectorField& field) const {
  forFilters(first, last, [&](const Filter& f) {
    if (f.rank > 0) field.set(f.particle, f.free * field.at(f.particle));
  });
}

void Contacts::dampSlides(const Particles& particles, const VectorField& u, float dt) {
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    const float most = most_stiffness / (particles.inverse_mass[i] * dt * dt);
    for (std::uint32_t k = filters_[f].first; k < filters_[f].last; ++k) {
      Contact& c = contacts_[k];
      const float force = c.friction.norm(), slip = tangential(u.at(i) - c.drift, c.normal).norm();
      if (c.state == Contact::State::slide && force > 0.0f)
        c.damping = force < most * slip ? force / slip : most;
    }
  });
}

/// Force of the spring to the anchor.
Eigen::Vector3f Contacts::pull(const Contact& c, const Vector& u) const {
  return c.stiffness * tangential(c.anchor - u, c.normal);
}

Eigen::Vector3f Contacts::frictionOn(const Contact& c, const VectorField& u) const {
  switch (c.state) {
    case Contact::State::slide:
      if (c.damping > 0.0f) return -c.damping * tangential(u.at(c.particle) - c.drift, c.normal);
      return c.friction;
    case Contact::State::stick:
      return pull(c, u.at(c.particle));
    case Contact::State::open:
      break;
  }
  return Vector::Zero();
}

void Contacts::addFriction(const VectorField& u, std::size_t first, std::size_t last,
                           VectorField& force) const {
  forFilters(first, last, [&](const Filter& f) {
    for (std::uint32_t k = f.first; k < f.last; ++k) force.add(f.particle, frictionOn(contacts_[k], u));
  });
}

void Contacts::addFrictionChange(const VectorField& p, std::size_t first, std::size_t last,
                                 VectorField& force) const {
  forFilters(first, last, [&](const Filter& f) {
    for (std::uint32_t k = f.first; k < f.last; ++k) {
      const Contact& c = contacts_[k];
      if (c.state == Contact::State::open) continue;
      const float resistance = c.state == Contact::State::stick ? c.stiffness : c.damping;
      force.add(f.particle, -resistance * tangential(p.at(f.particle), c.normal));
    }
  });
}

Contacts::Changes Contacts::update(const Particles& particles, const VectorField& u,
                                   const VectorField& residual) {
  std::atomic<bool> changed{false};
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    Filter& filter = filters_[f];
    filter.pulled = 0.0f;
    // What the contacts must add for the particle to move as prescribed.
    Vector needed = filter.free * residual.at(filter.particle) - residual.at(filter.particle);
    // The same without the friction on the particle. Where two obstacles slide on it, each would press harder
    // for the other's friction, and rub harder for that, without end.
    Vector loaded = needed;
    if (filter.last > filter.first + 1) {
      for (std::uint32_t k = filter.first; k < filter.last; ++k) loaded += frictionOn(contacts_[k], u);
      loaded -= filter.free * loaded;
    }
    for (std::uint32_t k = filter.first; k < filter.last; ++k) {
      Contact& c = contacts_[k];
      c.force.setZero();
      if (c.state == Contact::State::open) {
        if (c.normal.dot(u.at(c.particle)) < c.gap) changed = true;
        continue;
      }
      const float pressing = needed.dot(c.normal);
      needed -= pressing * c.normal;
      const float load = loaded.dot(c.normal);
      loaded -= load * c.normal;
      // the force that acted in this round, a pull too; the new state acts in the next
      const Vector trial = pull(c, u.at(c.particle));
      const Vector rubbing = frictionOn(c, u), slip = tangential(u.at(c.particle) - c.drift, c.normal);
      c.force = pressing * c.normal + rubbing;
      c.paid = c.state == Contact::State::stick
                   ? 0.5f * trial.dot(tangential(c.anchor - u.at(c.particle), c.normal))
                   : 0.5f * c.stiffness * tangential(c.anchor - c.drift, c.normal).squaredNorm() +
                         std::max(-rubbing.dot(slip), 0.0f);
      c.damping = 0.0f;
      if (pressing < -adhesion(c, particles)) {
        if (c.gap < 0.0f && c.solid != Contact::skin) filter.pulled += pressing * c.gap;
        c.state = Contact::State::open;
        c.friction.setZero();
        changed = true;
        continue;
      }
      const float holding = std::min(pressing, load) + adhesion(c, particles);
      const float limit = friction(c, particles) * std::max(holding, 0.0f), size = trial.norm();
      // A particle that friction would turn around comes to rest first.
      const bool turned = c.state == Contact::State::slide && trial.dot(c.friction) < 0.0f;
      const bool slides = size > limit && !turned;
      if (slides || c.state == Contact::State::slide) changed = true;  // its friction is another one now
      c.state = slides ? Contact::State::slide : Contact::State::stick;
      c.friction = size > limit ? Vector(limit / size * trial) : trial;
    }
  });
  Changes changes;
  changes.any = changed;
  for (const Filter& filter : filters_) changes.pulled += filter.pulled;
  return changes;
}

void Contacts::expel(const Particles& particles, VectorField& u, float dt) {
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    Vector step = u.at(i);
    expel(filters_[f], 1.0f / (particles.inverse_mass[i] * dt * dt), step);
    u.set(i, step);
  });
}

/// \param inertia N/m, of the particle \param u m, its displacement
void Contacts::expel(const Filter& filter, float inertia, Vector& u) {
  for (std::uint32_t k = filter.first; k < filter.last; ++k) {
    Contact& c = contacts_[k];
    if (depth(c, u) > 0.0f) push(c, depth(c, u) * c.normal, inertia, u);
  }
  Contact* nearest = nullptr;
  float share = 1.0f;
  for (std::uint32_t k = filter.first; k < filter.last; ++k) {
    Contact& c = contacts_[k];
    if (c.solid == Contact::skin) return;
    if (!(depth(c, u) > rounding * spacing_) || c.gap > 0.0f) continue;
    const float reached = c.gap / c.normal.dot(u);
    if (reached < share) share = reached, nearest = &c;
  }
  // Out of one solid into another it would gain energy: it goes no further than to the first on its way.
  if (nearest != nullptr) push(*nearest, (share - 1.0f) * u, inertia, u);
}

/// Moves a particle on, as its contact does.
void Contacts::push(Contact& c, const Vector& by, float inertia, Vector& u) {
  u += by;
  c.force += inertia * by;
  if (c.state == Contact::State::open) c.state = Contact::State::slide;
}

/// Where skin fills all there is, many particles look for places that there are not: together they look at no
/// more ghosts than `most_looks`, in equal parts, and those that found none by then stay where they are.
void Contacts::release(const Particles& particles, VectorField& u, float dt) {
  thread_local std::vector<std::uint32_t> held;
  held.assign(filters_.size(), 0);
  parallelFor(filters_.size(), 64, [&, is_held = held.data()](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    is_held[f] = isHeld(filters_[f], particles.position.at(i), u.at(i)) ? 1 : 0;
  });
  std::size_t count = 0;
  for (std::uint32_t f = 0; f < filters_.size(); ++f)
    if (held[f] != 0) held[count++] = f;
  held.resize(count);
  if (count == 0) return;
  const std::int64_t part = most_looks / static_cast<std::int64_t>(count);
  std::atomic<std::int64_t> looked{0};
  parallelFor(count, 4, [&, held_filters = held.data()](std::size_t k) {
    const Filter& filter = filters_[held_filters[k]];
    const std::uint32_t i = filter.particle;
    Vector step = u.at(i);
    const Vector x = particles.position.at(i) + step;
    std::int64_t looks = part;
    const std::optional<Vector> place = wayOut(x, looks);
    looked += part - looks;
    if (!place) return;
    const auto along = [&](const Contact& a, const Contact& b) {
      return a.normal.dot(*place - x) < b.normal.dot(*place - x);
    };
    Contact& c = *std::max_element(contacts_.begin() + filter.first, contacts_.begin() + filter.last, along);
    push(c, *place - x, 1.0f / (particles.inverse_mass[i] * dt * dt), step);
    u.set(i, step);
  });
  looks_ = static_cast<std::uint64_t>(looked.load());
}

/// Whether the skin holds a particle where its contacts lead none out. \param x m, where it starts
bool Contacts::isHeld(const Filter& filter, const Vector& x, const Vector& step) const {
  bool held = false, by_skin = false, leads_far = false;
  for (std::uint32_t k = filter.first; k < filter.last; ++k) {
    const Contact& c = contacts_[k];
    held = held || depth(c, step) > rounding * spacing_;
    if (c.solid != Contact::skin) continue;
    by_skin = true;
    leads_far = leads_far || (step - c.drift).norm() > plane * spacing_;
  }
  if (!by_skin) return false;
  const Vector end = x + step;
  return held || isCovered(filter, end, 0.0f) || (leads_far && obstacles_.isInFlesh(end));
}

/// Whether a place is beneath what is nearest to it of a side of the skin that touches the particle, or all
/// but is. A side is the mean of the skin nearby, and where fingers overlap, some of that is before the mean.
/// \param clearance m
bool Contacts::isCovered(const Filter& filter, const Vector& x, float clearance) const {
  const std::vector<Vector>& skin = obstacles_.ghosts().position;
  const auto distance = [&](const GhostShare& s) { return (x - skin[s.ghost]).squaredNorm(); };
  const auto isCovering = [&](const Contact& c) {
    if (c.solid != Contact::skin) return false;
    const auto first = shares_.begin() + c.first_ghost;
    const auto nearest =
        std::min_element(first, first + c.ghost_count,
                         [&](const GhostShare& a, const GhostShare& b) { return distance(a) < distance(b); });
    return obstacles_.covers(nearest->ghost, x, clearance);
  };
  return std::any_of(contacts_.begin() + filter.first, contacts_.begin() + filter.last, isCovering);
}

/// A free place near x: one that is not far if there is any, though it leave a particle less than half a
/// spacing off where there is no room for that. \param looks as of Obstacles::nearestFree
std::optional<Vector> Contacts::wayOut(const Vector& x, std::int64_t& looks) const {
  struct Attempt {
    float clearance, most;  // spacings
  };
  for (const Attempt& a : {Attempt{0.5f, 2.0f}, {0.25f, 2.0f}, {0.25f, farthest}, {narrow, farthest}}) {
    if (looks <= 0) break;
    const auto place = obstacles_.nearestFree(x, a.clearance * spacing_, a.most * spacing_, looks);
    if (place) return place;
  }
  return std::nullopt;
}

void Contacts::stop(const Particles& particles, const VectorField& u, VectorField& w) const {
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    const Filter& filter = filters_[f];
    const std::uint32_t i = filter.particle;
    const Vector x = particles.position.at(i) + u.at(i);
    Vector step = w.at(i);
    if (step.isZero(0.0f)) return;
    bool squeezed = false;
    for (std::uint32_t k = filter.first; k < filter.last; ++k) {
      const Contact& c = contacts_[k];
      const float left = depth(c, u.at(i));
      squeezed = squeezed || left > rounding * spacing_;
      step += std::max(std::min(left, 0.0f) - c.normal.dot(step), 0.0f) * c.normal;
    }
    // The planes tell nothing about the way from where it was released to.
    if (squeezed || isCovered(filter, x + step, narrow * spacing_)) step.setZero();
    w.set(i, step);
  });
  parallelFor(w.size(), 64, [&](std::size_t i) {
    const Vector step = w.at(i), end = particles.position.at(i) + u.at(i) + step;
    if (!(step.norm() > rounding * spacing_)) return;
    if (obstacles_.isInFlesh(end) || obstacles_.isInSolid(end)) w.set(i, Vector::Zero());
  });
}

void Contacts::finish(const Particles& particles, float dt) {
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    for (std::uint32_t k = filters_[f].first; k < filters_[f].last; ++k) {
      Contact& c = contacts_[k];
      if (!(c.stiffness > 0.0f)) continue;
      // As stiff as the next step's load asks for; only half the way there, since a stiffness that follows a
      // trembling force would feed the trembling.
      const float limit = friction(c, particles) * (c.force.dot(c.normal) + adhesion(c, particles));
      const float unit = 1.0f / (particles.inverse_mass[i] * dt * dt);
      c.stiffness = std::clamp(0.5f * (c.stiffness + limit / (pre_sliding * spacing_)),
                               least_stiffness * unit, most_stiffness * unit);
      const float most = std::sqrt(2.0f * c.paid / c.stiffness), length = c.friction.norm() / c.stiffness;
      c.anchor = std::min(most / std::max(length, 1e-30f), 1.0f) / c.stiffness * c.friction;
    }
  });
}

}  // namespace tactile_clay::clay
