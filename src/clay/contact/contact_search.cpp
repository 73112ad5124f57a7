#include "clay/contact/contact_search.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "clay/contact/skin_side.h"
#include "clay/mesh.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

constexpr float patch = 1.25f;  // spacings, radius of the skin that a sample stands for
constexpr float margin = 0.5f;  // spacings to a contact that may still close in the step
// spacings; to this depth the skin pushes out particles that it did not hold in the step before.
constexpr float capture = 1.0f;
constexpr float skin_recovery_speed = 0.5f;  // m/s

constexpr std::size_t particles_a_chunk = 64;

using Vector = Eigen::Vector3f;

/// The tangent plane of a solid where a point on its way first comes near, so that the point passes no solid,
/// however thin. All arguments are in the solid's coordinate frame.
/// @param stride m, minimum way from one look to the next
/// @return normal of the plane, and distance of the start point from it; none if the point does not come near
std::optional<SurfacePoint> firstMet(const Solid& solid, const Eigen::Vector3d& point,
                                     const Eigen::Vector3d& motion, double near, double stride) {
  if (solid.mesh != nullptr && solid.mesh->atLeast(point) - motion.norm() > near) return std::nullopt;
  SurfacePoint touch = surface(solid, point);
  // The distance to the surface shrinks by at most the motion of the particle against it.
  const double way = motion.norm();
  if (touch.distance - way > near) return std::nullopt;
  Eigen::Vector3d at = point;
  for (double gone = 0.0; touch.distance > near && gone < way;) {
    gone = std::min(gone + std::max(touch.distance - near, stride), way);
    at = point + gone / way * motion;
    touch = surface(solid, at);
  }
  if (touch.distance > near) return std::nullopt;
  return SurfacePoint{touch.distance + touch.normal.dot(point - at), touch.normal};
}

/// Whether the skin held a particle in the step before.
/// @param contacts by particle
bool isHeld(const std::vector<Contact>& contacts, std::size_t particle) {
  const auto from = std::lower_bound(contacts.begin(), contacts.end(), particle,
                                     [](const Contact& c, std::size_t p) { return c.particle < p; });
  for (auto c = from; c != contacts.end() && c->particle == particle; ++c)
    if (c->solid == Contact::skin && c->state != Contact::State::open) return true;
  return false;
}

void append(const ContactSearch::Found& more, ContactSearch::Found& found) {
  for (ContactGeometry contact : more.contacts) {
    contact.first_sample += static_cast<std::uint32_t>(found.shares.size());
    found.contacts.push_back(contact);
  }
  found.shares.insert(found.shares.end(), more.shares.begin(), more.shares.end());
}

void clear(ContactSearch::Found& found) {
  found.contacts.clear();
  found.shares.clear();
}

}  // namespace

ContactSearch::Found& ContactSearch::findAtStart(const std::vector<Contact>& before,
                                                 const Neighbourhood& near, const Particles& particles,
                                                 const VectorField& guess, const Colliders& colliders,
                                                 float dt) {
  guess_ = &guess;
  const Step step{particles, guess, colliders, colliders.skin(), dt};
  candidates_.find(near, guess, step.skin, dt);
  findEach(particles.size(), particles_a_chunk, [&](std::size_t i, Found& found) {
    touchSkin(before, step, i, found);
    for (std::size_t s = 0; s < colliders.solids().size(); ++s) touchSolid(step, i, s, found);
  });
  return found_;
}

/// A particle that is struck goes to places that could not be foreseen at the start of the step. Over the way
/// of a particle that flies, the skin is no plane.
const ContactSearch::Found& ContactSearch::findStrays(const Particles& particles, const Colliders& colliders,
                                                      const VectorField& u, float dt) {
  const Step step{particles, u, colliders, colliders.skin(), dt};
  const float foreseen = margin * spacing_, far = Colliders::reach * spacing_;
  findEach(particles.size(), range_size, [&](std::size_t i, Found& found) {
    const bool led_off = (u.at(i) - guess_->at(i)).squaredNorm() > foreseen * foreseen;
    for (std::size_t s = 0; led_off && s < colliders.solids().size(); ++s) strayIntoSolid(step, i, s, found);
    if (led_off || u.at(i).squaredNorm() > far * far) strayIntoSkin(step, i, found);
  });
  return found_;
}

/// Calls find(i, found) for the n particles, and lists all results in the order of the particles.
template <typename F>
void ContactSearch::findEach(std::size_t n, std::size_t chunk_size, const F& find) {
  const std::size_t chunks = (n + chunk_size - 1) / chunk_size;
  chunks_.resize(std::max(chunks_.size(), chunks));  // unused chunks keep their memory
  parallelRanges(n, chunk_size, [&](std::size_t first, std::size_t last) {
    Found& found = chunks_[first / chunk_size];
    clear(found);
    for (std::size_t i = first; i < last; ++i) find(i, found);
  });
  clear(found_);
  for (std::size_t c = 0; c < chunks; ++c) append(chunks_[c], found_);
}

/// Finds the contacts of particle i with the skin. Samples that it starts deep beneath are ignored, since it
/// may as well be in front of the other side of a finger. A particle that the skin held in the step before
/// was pressed through it, and is pushed out from any depth.
void ContactSearch::touchSkin(const std::vector<Contact>& before, const Step& step, std::size_t i,
                              Found& found) const {
  const SkinCandidates::Range near = candidates_.of(i);
  if (near.first == near.last) return;
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  const float deepest = isHeld(before, i) ? Colliders::reach * spacing_ : capture * spacing_;
  thread_local std::vector<NearSample> rest;
  rest.clear();
  std::copy_if(near.first, near.last, std::back_inserter(rest),
               [&](const NearSample& c) { return heightAtStart(step, x, c.sample) >= -deepest; });
  touchSides(step, i, x, rest, found, [&](const SkinPlane& plane, ContactGeometry& contact) {
    const float allowance =
        std::max(clearance * spacing_ - plane.before - skin_recovery_speed * step.dt, 0.0f);
    contact.gap = clearance * spacing_ - plane.distance - allowance;
    return contact.normal.dot(u) < contact.gap + margin * spacing_;
  });
}

/// Finds contacts with the skin where particle i went through it, or else where it ends in it.
void ContactSearch::strayIntoSkin(const Step& step, std::size_t i, Found& found) const {
  const float radius = Colliders::reach * spacing_;
  const Skin& skin = step.skin;
  const Vector x = step.particles.position.at(i), u = step.u.at(i), end = x + u;
  thread_local std::vector<NearSample> rest;
  findCrossed(step, i, rest);
  if (rest.empty()) {
    step.colliders.forSamplesNear(end, end, radius, [&](std::size_t g) {
      const float square = (end - skin.position[g]).squaredNorm();
      if (square < radius * radius && heightAtStart(step, x, g) >= -capture * spacing_)
        rest.push_back({static_cast<std::uint32_t>(g), square});
    });
  }
  std::sort(rest.begin(), rest.end(),
            [](const NearSample& a, const NearSample& b) { return a.sample < b.sample; });
  touchSides(step, i, end, rest, found, [&](const SkinPlane& plane, ContactGeometry& contact) {
    const float depth = clearance * spacing_ - plane.distance;
    contact.gap = depth + contact.normal.dot(u);
    return depth > 0.0f;
  });
}

/// Finds the samples beside which particle i first goes from in front of the skin to behind it.
void ContactSearch::findCrossed(const Step& step, std::size_t i, std::vector<NearSample>& crossed) const {
  const float radius = Colliders::reach * spacing_;
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  thread_local std::vector<float> gone;  // m, way to the crossing, relative to the sample
  crossed.clear();
  gone.clear();
  step.colliders.forSamplesNear(x, x + u, radius, [&](std::size_t g) {
    const Vector motion = step.dt * step.skin.velocity[g], way = u - motion;
    const Vector start = x - (step.skin.position[g] - motion);
    const float before = step.skin.normal[g].dot(start), after = before + step.skin.normal[g].dot(way);
    if (!(before > 0.0f && after < 0.0f)) return;
    const float share = before / (before - after);
    const float square = (start + share * way).squaredNorm();
    if (!(square < patch * patch * spacing_ * spacing_)) return;
    crossed.push_back({static_cast<std::uint32_t>(g), square});
    gone.push_back(share * way.norm());
  });
  if (crossed.empty()) return;
  const float first = *std::min_element(gone.begin(), gone.end());
  std::size_t kept = 0;
  for (std::size_t k = 0; k < crossed.size(); ++k)
    if (gone[k] < first + radius) crossed[kept++] = crossed[k];
  crossed.resize(kept);
}

/// Adds the contacts of a particle with each side of the skin that the samples in `rest` make near x.
/// @param rest is emptied
/// @param touches sets the gap to a side, and returns whether it is a contact
template <typename F>
void ContactSearch::touchSides(const Step& step, std::size_t i, const Vector& x,
                               std::vector<NearSample>& rest, Found& found, const F& touches) const {
  thread_local std::vector<NearSample> side;
  while (!rest.empty()) {
    takeSide(step.skin, rest, side);
    ContactGeometry contact;
    contact.particle = static_cast<std::uint32_t>(i);
    contact.solid = Contact::skin;
    contact.first_sample = static_cast<std::uint32_t>(found.shares.size());
    contact.sample_count = static_cast<std::uint32_t>(side.size());
    const SkinPlane plane = planeOf(step.skin, side, x, Colliders::reach * spacing_, step.dt, found.shares);
    contact.normal = plane.normal;
    contact.drift = plane.drift;
    if (touches(plane, contact))
      found.contacts.push_back(contact);
    else
      found.shares.resize(contact.first_sample);
  }
}

/// How deep a particle may still be in a solid at the end of the step, m.
/// @param before its distance from the solid at the start, m
double ContactSearch::allowedDepth(double before, float dt) const {
  return std::max(clearance * spacing_ - before - solid_recovery_speed * dt, 0.0);
}

void ContactSearch::touchSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const {
  const Colliders::MovingSolid& moving = step.colliders.solids()[s];
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  const double near = (clearance + margin) * spacing_;
  if (!moving.mayMeet(x.cast<double>(), u.norm(), near)) return;
  const Eigen::Vector3d local = moving.to_start * x.cast<double>();
  const Eigen::Vector3d motion = moving.to_end * (x + u).cast<double>() - local;
  const auto met = firstMet(moving.solid, local, motion, near, 0.01 * spacing_);
  if (!met) return;
  ContactGeometry contact;
  contact.particle = static_cast<std::uint32_t>(i);
  contact.solid = static_cast<std::uint32_t>(s);
  contact.normal = (moving.end.linear() * met->normal).cast<float>();
  contact.drift = (moving.end * local).cast<float>() - x;
  const double allowance = allowedDepth(met->distance, step.dt);
  contact.gap = static_cast<float>(clearance * spacing_ - met->distance - allowance) +
                contact.normal.dot(contact.drift);
  if (contact.normal.dot(u) < contact.gap + margin * spacing_) found.contacts.push_back(contact);
}

/// Finds the contact with a solid if particle i ends deeper in it than recovery allows.
void ContactSearch::strayIntoSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const {
  const Colliders::MovingSolid& moving = step.colliders.solids()[s];
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  const SurfacePoint touch = surface(moving.solid, moving.to_end * (x + u).cast<double>());
  if (!(touch.distance < clearance * spacing_)) return;
  // At this depth the particle may be nearer to another side than to the one where it came in.
  if (touch.distance < -spacing_) return touchSolid(step, i, s, found);
  const double before = surface(moving.solid, moving.to_start * x.cast<double>()).distance;
  const auto depth =
      static_cast<float>(clearance * spacing_ - touch.distance - allowedDepth(before, step.dt));
  if (!(depth > 0.0f)) return;
  ContactGeometry contact;
  contact.particle = static_cast<std::uint32_t>(i);
  contact.solid = static_cast<std::uint32_t>(s);
  contact.normal = (moving.end.linear() * touch.normal).cast<float>();
  contact.gap = depth + contact.normal.dot(u);
  found.contacts.push_back(contact);
}

}  // namespace tactile_clay::clay
