#include "clay/contact_search.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "clay/mesh.h"
#include "clay/skin_side.h"
#include "clay/threads.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr float patch = 1.25f;   // spacings, about a ghost, of the skin that it stands for
constexpr float margin = 0.5f;   // spacings, of contacts that the step may yet close
constexpr float capture = 1.0f;  // spacings beneath the skin, from where it pushes out what it did not hold
constexpr float skin_recovery_speed = 0.5f;  // m/s

constexpr std::size_t ghosts_a_chunk = 256, particles_a_chunk = 64;

using Vector = Eigen::Vector3f;

struct Passed {               // ghost, in front of which particles pass
  Vector at, motion, normal;  // m, at the start of the step and in it
  float radius;               // m
};

/// Which of the eight particles from place k on come within the radius of a ghost at some time of the step,
/// having started in front of it or not far behind. Products are summed as Eigen sums them. \param nearest
/// gets the least squared distances in the step, m^2
TACTILE_CLAY_MULTIVERSION
unsigned passing(const Passed& ghost, const Neighbourhood::Places& places, std::uint32_t k,
                 const float* guess, float* nearest) {
  const LaneVector r{load(places.x + k) - ghost.at[0], load(places.y + k) - ghost.at[1],
                     load(places.z + k) - ghost.at[2]};
  const LaneVector u = gather(guess, places.slot + k);
  const LaneVector approach{u.x - ghost.motion[0], u.y - ghost.motion[1], u.z - ghost.motion[2]};
  const Lane square = approach.x * approach.x + (approach.y * approach.y + approach.z * approach.z);
  const Lane along = r.x * approach.x + (r.y * approach.y + r.z * approach.z);
  const Lane t = square > 0.0f ? least(positive(-along / square), all(1.0f)) : Lane{};
  const LaneVector then{r.x + t * approach.x, r.y + t * approach.y, r.z + t * approach.z};
  const Lane distance = then.x * then.x + (then.y * then.y + then.z * then.z);
  const Lane height = r.x * ghost.normal[0] + (r.y * ghost.normal[1] + r.z * ghost.normal[2]);
  store(nearest, distance);
  return bits((distance < ghost.radius * ghost.radius) & (height >= -ghost.radius));
}

Eigen::AlignedBox3f boxOf(const VectorField& field) {
  Eigen::Vector4f least = field.size() > 0 ? field[0] : Eigen::Vector4f::Zero(), most = least;
  for (std::size_t i = 0; i < field.size(); ++i)
    least = least.cwiseMin(field[i]), most = most.cwiseMax(field[i]);
  return {least.head<3>(), most.head<3>()};
}

/// The tangent plane of a solid where a point first comes near on its way, so that nothing is passed by
/// however thin it is. All is in the solid's frame. \param stride m, the least to go before looking anew
/// \return the plane's normal, and the distance from it of the point at the start
std::optional<SurfacePoint> firstMet(const Solid& solid, const Eigen::Vector3d& point,
                                     const Eigen::Vector3d& motion, double near, double stride) {
  if (solid.mesh != nullptr && solid.mesh->atLeast(point) - motion.norm() > near) return std::nullopt;
  SurfacePoint touch = surface(solid, point);
  // No point of a surface comes nearer than the particle moves against it.
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

/// Whether the skin held a particle. \param contacts by particle
bool isHeld(const std::vector<Contact>& contacts, std::size_t particle) {
  const auto from = std::lower_bound(contacts.begin(), contacts.end(), particle,
                                     [](const Contact& c, std::size_t p) { return c.particle < p; });
  for (auto c = from; c != contacts.end() && c->particle == particle; ++c)
    if (c->solid == Contact::skin && c->state != Contact::State::open) return true;
  return false;
}

void append(const ContactSearch::Found& more, ContactSearch::Found& found) {
  for (Contact contact : more.contacts) {
    contact.first_ghost += static_cast<std::uint32_t>(found.shares.size());
    found.contacts.push_back(contact);
  }
  found.shares.insert(found.shares.end(), more.shares.begin(), more.shares.end());
}

void clear(ContactSearch::Found& found) {
  found.contacts.clear(), found.shares.clear();
}

}  // namespace

ContactSearch::Found& ContactSearch::findAtStart(const std::vector<Contact>& before,
                                                 const Neighbourhood& near, const Particles& particles,
                                                 const VectorField& guess, const Obstacles& obstacles,
                                                 float dt) {
  guess_ = &guess;
  const Step step{particles, guess, obstacles, obstacles.ghosts(), dt};
  findCandidates(near, step);
  sortCandidates(particles.size());
  findEach(particles.size(), particles_a_chunk, [&](std::size_t i, Found& found) {
    touchSkin(before, step, i, found);
    for (std::size_t s = 0; s < obstacles.solids().size(); ++s) touchSolid(step, i, s, found);
  });
  return found_;
}

/// What is struck goes where nothing led to at the start of the step; and over the way of what flies, the
/// skin is no plane.
const ContactSearch::Found& ContactSearch::findStrays(const Particles& particles, const Obstacles& obstacles,
                                                      const VectorField& u, float dt) {
  const Step step{particles, u, obstacles, obstacles.ghosts(), dt};
  const float foreseen = margin * spacing_, far = Obstacles::reach * spacing_;
  findEach(particles.size(), range_size, [&](std::size_t i, Found& found) {
    const bool led_off = (u.at(i) - guess_->at(i)).squaredNorm() > foreseen * foreseen;
    for (std::size_t s = 0; led_off && s < obstacles.solids().size(); ++s) strayIntoSolid(step, i, s, found);
    if (led_off || u.at(i).squaredNorm() > far * far) strayIntoSkin(step, i, found);
  });
  return found_;
}

/// Calls find(i, found) for the n particles and lists what they find in this order.
template <typename F>
void ContactSearch::findEach(std::size_t n, std::size_t chunk_size, const F& find) {
  const std::size_t chunks = (n + chunk_size - 1) / chunk_size;
  chunks_.resize(std::max(chunks_.size(), chunks));  // what fewer chunks leave unused keeps its memory
  parallelRanges(n, chunk_size, [&](std::size_t first, std::size_t last) {
    Found& found = chunks_[first / chunk_size];
    clear(found);
    for (std::size_t i = first; i < last; ++i) find(i, found);
  });
  clear(found_);
  for (std::size_t c = 0; c < chunks; ++c) append(chunks_[c], found_);
}

void ContactSearch::findCandidates(const Neighbourhood& near, const Step& step) {
  const std::size_t ghosts = step.ghosts.size();
  const Eigen::AlignedBox3f ways = boxOf(step.u);
  passing_.resize((ghosts + ghosts_a_chunk - 1) / ghosts_a_chunk);
  parallelRanges(ghosts, ghosts_a_chunk, [&](std::size_t first, std::size_t last) {
    std::vector<Candidate>& candidates = passing_[first / ghosts_a_chunk];
    candidates.clear();
    for (std::size_t g = first; g < last; ++g)
      findPassing(near, step, ways, static_cast<std::uint32_t>(g), candidates);
  });
}

/// Particles that pass within the radius R of a ghost at some time of the step, having started in front of
/// it, or not deeper beneath it than that. \param ways m, what holds the displacements of all particles
void ContactSearch::findPassing(const Neighbourhood& near, const Step& step, const Eigen::AlignedBox3f& ways,
                                std::uint32_t g, std::vector<Candidate>& candidates) const {
  const float radius = Obstacles::reach * spacing_;
  const Neighbourhood::Places places = near.places();
  const Vector motion = step.dt * step.ghosts.velocity[g];
  const Passed ghost{step.ghosts.position[g] - motion, motion, step.ghosts.normal[g], radius};
  const Vector low = ghost.at + (motion - ways.max()).cwiseMin(0.0f) - Vector::Constant(radius);
  const Vector high = ghost.at + (motion - ways.min()).cwiseMax(0.0f) + Vector::Constant(radius);
  near.forEachRun(low, high, [&](std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t k = from; k < to; k += lane_width) {
      float nearest[lane_width];
      unsigned hits = passing(ghost, places, k, step.u.data(), nearest);
      if (to - k < lane_width) hits &= (1u << (to - k)) - 1u;
      for (; hits != 0; hits &= hits - 1u) {
        const int lane = __builtin_ctz(hits);
        candidates.push_back({places.slot[k + lane] / slot_size, {g, nearest[lane]}});
      }
    }
  });
}

void ContactSearch::sortCandidates(std::size_t particles) {
  near_ghost_end_.assign(particles + 1, 0);
  for (const std::vector<Candidate>& chunk : passing_)
    for (const Candidate& c : chunk) ++near_ghost_end_[c.particle + 1];
  for (std::size_t i = 0; i < particles; ++i) near_ghost_end_[i + 1] += near_ghost_end_[i];
  near_ghosts_.resize(near_ghost_end_.back());
  for (const std::vector<Candidate>& chunk : passing_)
    for (const Candidate& c : chunk) near_ghosts_[near_ghost_end_[c.particle]++] = c.near;
}

/// Contacts of particle i with the skin. What was deep beneath the skin all the time may as
/// well be in front of the other side of a finger. What the skin held in the step before was pressed through
/// it, and is pushed out from any depth.
void ContactSearch::touchSkin(const std::vector<Contact>& before, const Step& step, std::size_t i,
                              Found& found) const {
  const std::uint32_t first = i > 0 ? near_ghost_end_[i - 1] : 0, last = near_ghost_end_[i];
  if (first == last) return;
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  const float deepest = isHeld(before, i) ? Obstacles::reach * spacing_ : capture * spacing_;
  thread_local std::vector<NearGhost> rest;
  rest.clear();
  std::copy_if(near_ghosts_.begin() + first, near_ghosts_.begin() + last, std::back_inserter(rest),
               [&](const NearGhost& c) { return heightAtStart(step, x, c.ghost) >= -deepest; });
  touchSides(step, i, x, rest, found, [&](const SkinPlane& plane, Contact& contact) {
    const float allowance = std::max(0.5f * spacing_ - plane.before - skin_recovery_speed * step.dt, 0.0f);
    contact.gap = 0.5f * spacing_ - plane.distance - allowance;
    return contact.normal.dot(u) < contact.gap + margin * spacing_;
  });
}

/// Where particle i went through the skin, or ends in it: its tangent planes there.
void ContactSearch::strayIntoSkin(const Step& step, std::size_t i, Found& found) const {
  const float radius = Obstacles::reach * spacing_;
  const Ghosts& ghosts = step.ghosts;
  const Vector x = step.particles.position.at(i), u = step.u.at(i), end = x + u;
  thread_local std::vector<NearGhost> rest;
  findCrossed(step, i, rest);
  if (rest.empty()) {
    step.obstacles.forGhostsNear(end, end, radius, [&](std::size_t g) {
      const float square = (end - ghosts.position[g]).squaredNorm();
      if (square < radius * radius && heightAtStart(step, x, g) >= -capture * spacing_)
        rest.push_back({static_cast<std::uint32_t>(g), square});
    });
  }
  std::sort(rest.begin(), rest.end(),
            [](const NearGhost& a, const NearGhost& b) { return a.ghost < b.ghost; });
  touchSides(step, i, end, rest, found, [&](const SkinPlane& plane, Contact& contact) {
    const float depth = 0.5f * spacing_ - plane.distance;
    contact.gap = depth + contact.normal.dot(u);
    return depth > 0.0f;
  });
}

/// Ghosts beside which particle i goes from in front of the skin to behind it, where it first does so.
void ContactSearch::findCrossed(const Step& step, std::size_t i, std::vector<NearGhost>& crossed) const {
  const float radius = Obstacles::reach * spacing_;
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  thread_local std::vector<float> gone;  // m, on the way to where it crosses, as the ghost sees it
  crossed.clear(), gone.clear();
  step.obstacles.forGhostsNear(x, x + u, radius, [&](std::size_t g) {
    const Vector motion = step.dt * step.ghosts.velocity[g], way = u - motion;
    const Vector start = x - (step.ghosts.position[g] - motion);
    const float before = step.ghosts.normal[g].dot(start), after = before + step.ghosts.normal[g].dot(way);
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

/// Contacts of a particle with each side of the skin that its candidates make near x.
/// \param rest is used up \param touches sets the gap to a side and tells whether it is a contact
template <typename F>
void ContactSearch::touchSides(const Step& step, std::size_t i, const Vector& x, std::vector<NearGhost>& rest,
                               Found& found, const F& touches) const {
  thread_local std::vector<NearGhost> side;
  while (!rest.empty()) {
    takeSide(step.ghosts, rest, side);
    Contact contact;
    contact.particle = static_cast<std::uint32_t>(i), contact.solid = Contact::skin;
    contact.first_ghost = static_cast<std::uint32_t>(found.shares.size());
    contact.ghost_count = static_cast<std::uint32_t>(side.size());
    const SkinPlane plane = planeOf(step.ghosts, side, x, Obstacles::reach * spacing_, step.dt, found.shares);
    contact.normal = plane.normal, contact.drift = plane.drift;
    if (touches(plane, contact))
      found.contacts.push_back(contact);
    else
      found.shares.resize(contact.first_ghost);
  }
}

/// How deep a particle may still be in a solid at the end of the step, m. \param before its distance at the
/// start, m
double ContactSearch::allowedDepth(double before, float dt) const {
  return std::max(0.5 * spacing_ - before - solid_recovery_speed * dt, 0.0);
}

void ContactSearch::touchSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const {
  const Obstacles::MovingSolid& moving = step.obstacles.solids()[s];
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  const double near = (0.5 + margin) * spacing_;
  if (!moving.mayMeet(x.cast<double>(), u.norm(), near)) return;
  const Eigen::Vector3d local = moving.to_start * x.cast<double>();
  const Eigen::Vector3d motion = moving.to_end * (x + u).cast<double>() - local;
  const auto met = firstMet(moving.solid, local, motion, near, 0.01 * spacing_);
  if (!met) return;
  Contact contact;
  contact.particle = static_cast<std::uint32_t>(i), contact.solid = static_cast<std::uint32_t>(s);
  contact.normal = (moving.end.linear() * met->normal).cast<float>();
  contact.drift = (moving.end * local).cast<float>() - x;
  const double allowance = allowedDepth(met->distance, step.dt);
  contact.gap =
      static_cast<float>(0.5 * spacing_ - met->distance - allowance) + contact.normal.dot(contact.drift);
  if (contact.normal.dot(u) < contact.gap + margin * spacing_) found.contacts.push_back(contact);
}

/// Where particle i ends deeper in a solid than recovery leaves it.
void ContactSearch::strayIntoSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const {
  const Obstacles::MovingSolid& moving = step.obstacles.solids()[s];
  const Vector x = step.particles.position.at(i), u = step.u.at(i);
  const SurfacePoint touch = surface(moving.solid, moving.to_end * (x + u).cast<double>());
  if (!(touch.distance < 0.5 * spacing_)) return;
  // As deep as that, it may be nearer to another side than that where it came in.
  if (touch.distance < -spacing_) return touchSolid(step, i, s, found);
  const double before = surface(moving.solid, moving.to_start * x.cast<double>()).distance;
  const auto depth = static_cast<float>(0.5 * spacing_ - touch.distance - allowedDepth(before, step.dt));
  if (!(depth > 0.0f)) return;
  Contact contact;
  contact.particle = static_cast<std::uint32_t>(i), contact.solid = static_cast<std::uint32_t>(s);
  contact.normal = (moving.end.linear() * touch.normal).cast<float>();
  contact.gap = depth + contact.normal.dot(u);
  found.contacts.push_back(contact);
}

}  // namespace tactile_clay::clay
