#include <algorithm>
#include <atomic>

#include "clay/contact/contacts.h"

namespace tactile_clay::clay {
namespace {

constexpr float farthest = 6.0f;   // spacings, by which clay between skins is moved at most
constexpr float plane = 0.25f;     // spacings, over which the skin counts as a plane
constexpr float narrow = 0.1f;     // spacings, between skin and particle where there is hardly any room
constexpr float rounding = 1e-3f;  // spacings

using Vector = Eigen::Vector3f;

}  // namespace

void Contacts::expel(const Particles& particles, VectorField& u, float dt) {
  forEach(filters_.size(), [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    Vector step = u.at(i);
    expel(filters_[f], 1.0f / (particles.inverse_mass[i] * dt * dt), step);
    u.set(i, step);
  });
}

/// @param inertia N/m, of the particle
/// @param u m, its displacement
void Contacts::expel(const Filter& filter, float inertia, Vector& u) {
  for (Contact& c : of(filter))
    if (c.depth(u) > 0.0f) push(c, c.depth(u) * c.normal, inertia, u);
  Contact* nearest = nullptr;
  float share = 1.0f;
  for (Contact& c : of(filter)) {
    if (c.solid == Contact::skin) return;
    if (!(c.depth(u) > rounding * spacing_) || c.gap > 0.0f) continue;
    const float reached = c.gap / c.normal.dot(u);
    if (reached < share) {
      share = reached;
      nearest = &c;
    }
  }
  // Pushed out of one solid into another, the particle would gain energy: it stops at the first solid on its
  // way.
  if (nearest != nullptr) push(*nearest, (share - 1.0f) * u, inertia, u);
}

/// Moves a particle on, and adds the force of this motion to its contact.
void Contacts::push(Contact& c, const Vector& by, float inertia, Vector& u) {
  u += by;
  c.force += inertia * by;
  if (c.state == Contact::State::open) c.state = Contact::State::slide;
}

/// If skin fills all the space, many particles search for places that do not exist. So together they look at
/// no more samples than `max_looks`, in equal parts. A particle that has found no place by then stays where
/// it is.
void Contacts::release(const Particles& particles, VectorField& u, float dt) {
  const std::vector<std::uint32_t> held_filters = held(particles, u);
  if (held_filters.empty()) return;
  const std::int64_t part = max_looks / static_cast<std::int64_t>(held_filters.size());
  constexpr std::size_t grain = 4;  // searches that a thread takes at a time; each may be long
  std::atomic<std::int64_t> looked{0};
  parallelFor(held_filters.size(), grain, [&](std::size_t k) {
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
    Contact& c = *std::max_element(of(filter).begin(), of(filter).end(), along);
    push(c, *place - x, 1.0f / (particles.inverse_mass[i] * dt * dt), step);
    u.set(i, step);
  });
  looks_ = static_cast<std::uint64_t>(looked.load());
}

/// Indices of the filters of particles that the skin still holds, because their contacts do not lead them
/// out.
std::vector<std::uint32_t> Contacts::held(const Particles& particles, const VectorField& u) const {
  thread_local std::vector<std::uint8_t> holds;
  holds.assign(filters_.size(), 0);
  forEach(filters_.size(), [&, is_held = holds.data()](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    is_held[f] = isHeld(filters_[f], particles.position.at(i), u.at(i)) ? 1 : 0;
  });
  std::vector<std::uint32_t> list;
  for (std::uint32_t f = 0; f < filters_.size(); ++f)
    if (holds[f] != 0) list.push_back(f);
  return list;
}

/// @param x m, position of the particle at the start of the step
bool Contacts::isHeld(const Filter& filter, const Vector& x, const Vector& step) const {
  bool held = false, by_skin = false, leads_far = false;
  for (const Contact& c : of(filter)) {
    held = held || c.depth(step) > rounding * spacing_;
    if (c.solid != Contact::skin) continue;
    by_skin = true;
    leads_far = leads_far || (step - c.drift).norm() > plane * spacing_;
  }
  if (!by_skin) return false;
  const Vector end = x + step;
  return held || isCovered(filter, end, 0.0f) || (leads_far && colliders_.isInFlesh(end));
}

/// Whether a place is beneath the nearest sample of a side of the skin that touches the particle, or less
/// than `clearance` above it. A side is the mean of the skin nearby; where fingers overlap, some of this skin
/// lies before the mean.
/// @param clearance m
bool Contacts::isCovered(const Filter& filter, const Vector& x, float clearance) const {
  const std::vector<Vector>& skin = colliders_.skin().position;
  const auto nearer = [&](const SampleShare& a, const SampleShare& b) {
    return (x - skin[a.sample]).squaredNorm() < (x - skin[b.sample]).squaredNorm();
  };
  const auto isCovering = [&](const Contact& c) {
    if (c.solid != Contact::skin) return false;
    const auto first = shares_.begin() + c.first_sample;
    const auto nearest = std::min_element(first, first + c.sample_count, nearer);
    return colliders_.covers(nearest->sample, x, clearance);
  };
  return std::any_of(of(filter).begin(), of(filter).end(), isCovering);
}

/// A free place near x. If there is no room for half a spacing of clearance, a near place with less clearance
/// is preferred to a far one.
/// @param looks as in Colliders::nearestFree
std::optional<Vector> Contacts::wayOut(const Vector& x, std::int64_t& looks) const {
  struct Attempt {
    float clearance, maximum;  // spacings
  };
  for (const Attempt& a :
       {Attempt{ContactSearch::clearance, 2.0f}, {0.25f, 2.0f}, {0.25f, farthest}, {narrow, farthest}}) {
    if (looks <= 0) break;
    const auto place = colliders_.nearestFree(x, a.clearance * spacing_, a.maximum * spacing_, looks);
    if (place) return place;
  }
  return std::nullopt;
}

void Contacts::stop(const Particles& particles, const VectorField& u, VectorField& w) const {
  forEach(filters_.size(), [&](std::size_t f) {
    const Filter& filter = filters_[f];
    const std::uint32_t i = filter.particle;
    const Vector x = particles.position.at(i) + u.at(i);
    Vector step = w.at(i);
    if (step.isZero(0.0f)) return;
    bool squeezed = false;
    for (const Contact& c : of(filter)) {
      const float left = c.depth(u.at(i));
      squeezed = squeezed || left > rounding * spacing_;
      step += std::max(std::min(left, 0.0f) - c.normal.dot(step), 0.0f) * c.normal;
    }
    // The planes do not describe the way on from the place to which `release` moved the particle.
    if (squeezed || isCovered(filter, x + step, narrow * spacing_)) step.setZero();
    w.set(i, step);
  });
  forEach(w.size(), [&](std::size_t i) {
    const Vector step = w.at(i), end = particles.position.at(i) + u.at(i) + step;
    if (!(step.norm() > rounding * spacing_)) return;
    if (colliders_.isInFlesh(end) || colliders_.isInSolid(end)) w.set(i, Vector::Zero());
  });
}

}  // namespace tactile_clay::clay
