#include "clay/contacts.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "clay/lanes.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

constexpr float reach = 1.5f;           // spacings, R: ghosts this near make the skin at a particle
constexpr float margin = 0.5f;          // spacings, of contacts that the step may yet close
constexpr float capture = 1.0f;         // spacings beneath the skin from which clay is still pushed out
constexpr float recovery_speed = 0.5f;  // m/s, at which an old penetration is undone, so that none explodes
constexpr float pre_sliding = 0.01f;  // spacings, by which a friction spring gives before its contact slides
constexpr float least_stiffness = 20.0f, most_stiffness = 500.0f;  // its range, particle masses per step^2
constexpr float same_side = 0.2f;                                  // cosine between normals of one side

using Vector = Eigen::Vector3f;

Vector tangential(const Vector& v, const Vector& n) {
  return v - v.dot(n) * n;
}

struct Passed {               // ghost, in front of which particles pass
  Vector at, motion, normal;  // m, at the start of the step and in it
  float radius, behind;       // m
};

/// Which of the eight particles from place k on come within the radius of a ghost at some time of the step,
/// having started in front of it. Products are summed as Eigen sums them. \param nearest gets the least
/// squared distances in the step, m^2
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
  return bits((distance < ghost.radius * ghost.radius) & (height >= -ghost.behind));
}

}  // namespace

Contacts::Contacts(float spacing, const std::vector<Material>& materials) : spacing_(spacing) {
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
  previous_.swap(contacts_);
  contacts_.clear(), shares_.clear();
  guess_ = &guess, solids_ = solids, solids_end_ = end;
  detectSkin(near, particles, guess, ghosts, dt);
  detectSolids(particles, guess, solids, start, end, dt);
  sortContacts();
  recall(particles, dt);
}

void Contacts::sortContacts() {
  std::stable_sort(contacts_.begin(), contacts_.end(),
                   [](const Contact& a, const Contact& b) { return a.particle < b.particle; });
  filters_.clear();
  for (std::uint32_t c = 0; c < contacts_.size(); ++c) {
    if (filters_.empty() || filters_.back().particle != contacts_[c].particle) {
      filters_.push_back({contacts_[c].particle, c, c + 1, 0, Eigen::Matrix3f::Identity()});
    } else {
      filters_.back().last = c + 1;
    }
  }
}

void Contacts::detectSkin(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
                          const Ghosts& ghosts, float dt) {
  if (ghosts.size() == 0) return;
  Eigen::Vector4f least = guess.size() > 0 ? guess[0] : Eigen::Vector4f::Zero(), most = least;
  for (std::size_t i = 0; i < guess.size(); ++i)
    least = least.cwiseMin(guess[i]), most = most.cwiseMax(guess[i]);

  constexpr std::size_t ghosts_a_chunk = 256, runs_a_chunk = 32;
  found_.resize((ghosts.size() + ghosts_a_chunk - 1) / ghosts_a_chunk);
  parallelFor(found_.size(), 1, [&](std::size_t c) {
    found_[c].candidates.clear();
    const std::size_t first = c * ghosts_a_chunk;
    findCandidates(near, guess, ghosts, dt, {least.head<3>(), most.head<3>()}, first,
                   std::min(ghosts.size(), first + ghosts_a_chunk), found_[c].candidates);
  });
  // Sorted by particle: a run holds the candidates of one.
  candidate_place_.assign(particles.size() + 1, 0);
  for (const Found& found : found_)
    for (const Candidate& c : found.candidates) ++candidate_place_[c.particle + 1];
  runs_.clear();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (candidate_place_[i + 1] > 0) runs_.push_back(candidate_place_[i]);
    candidate_place_[i + 1] += candidate_place_[i];
  }
  candidates_.resize(candidate_place_.back());
  for (const Found& found : found_)
    for (const Candidate& c : found.candidates) candidates_[candidate_place_[c.particle]++] = c;

  const std::size_t runs = runs_.size();
  runs_.push_back(static_cast<std::uint32_t>(candidates_.size()));
  found_.resize((runs + runs_a_chunk - 1) / runs_a_chunk);
  parallelFor(found_.size(), 1, [&](std::size_t c) {
    found_[c].contacts.clear(), found_[c].shares.clear();
    for (std::size_t r = c * runs_a_chunk; r < std::min(runs, (c + 1) * runs_a_chunk); ++r)
      touchSkin(particles, guess, ghosts, dt, runs_[r], runs_[r + 1], found_[c]);
  });
  for (const Found& found : found_) add(found);
}

void Contacts::add(const Found& found) {
  for (Contact contact : found.contacts) {
    contact.first_ghost += static_cast<std::uint32_t>(shares_.size());
    contacts_.push_back(contact);
  }
  shares_.insert(shares_.end(), found.shares.begin(), found.shares.end());
}

/// Particles that pass within the radius R of the ghosts [first, last) at some time of the step, having
/// started in front of them.
void Contacts::findCandidates(const Neighbourhood& near, const VectorField& guess, const Ghosts& ghosts,
                              float dt, const Eigen::AlignedBox3f& guesses, std::size_t first,
                              std::size_t last, std::vector<Candidate>& candidates) const {
  const float radius = reach * spacing_;
  const Neighbourhood::Places places = near.places();
  for (std::size_t g = first; g < last; ++g) {
    const Vector motion = dt * ghosts.velocity[g];
    const Passed ghost{ghosts.position[g] - motion, motion, ghosts.normal[g], radius, capture * spacing_};
    const Vector low = ghost.at + (motion - guesses.max()).cwiseMin(0.0f) - Vector::Constant(radius);
    const Vector high = ghost.at + (motion - guesses.min()).cwiseMax(0.0f) + Vector::Constant(radius);
    near.forEachRun(low, high, [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t k = from; k < to; k += lane_width) {
        float nearest[lane_width];
        unsigned hits = passing(ghost, places, k, guess.data(), nearest);
        if (to - k < lane_width) hits &= (1u << (to - k)) - 1u;
        for (; hits != 0; hits &= hits - 1u) {
          const int lane = __builtin_ctz(hits);
          candidates.push_back(
              {places.slot[k + lane] / slot_size, static_cast<std::uint32_t>(g), nearest[lane]});
        }
      }
    });
  }
}

/// Moves the candidates that face as the nearest does from `rest` to `side`.
void Contacts::takeSide(const Ghosts& ghosts, std::vector<Candidate>& rest, std::vector<Candidate>& side) {
  const Candidate closest = *std::min_element(
      rest.begin(), rest.end(), [](const Candidate& a, const Candidate& b) { return a.nearest < b.nearest; });
  const Vector facing = ghosts.normal[closest.ghost];
  const auto split = std::stable_partition(rest.begin(), rest.end(), [&](const Candidate& a) {
    return ghosts.normal[a.ghost].dot(facing) <= same_side;
  });
  side.assign(split, rest.end());
  rest.erase(split, rest.end());
}

/// The tangent plane of a side of the skin near x, the mean of its candidates by weights that fall with the
/// distance to the particle's way; these are added to `shares`.
Contacts::SkinPlane Contacts::planeOf(const Ghosts& ghosts, const std::vector<Candidate>& side,
                                      const Vector& x, float dt, std::vector<GhostShare>& shares) const {
  const float radius = reach * spacing_;
  const std::size_t first_share = shares.size();
  float total = 0.0f;
  SkinPlane plane;
  for (const Candidate& a : side) {
    const float q = a.nearest / (radius * radius);
    const float weight = std::max((1.0f - q) * (1.0f - q), 1e-6f);
    const Vector motion = dt * ghosts.velocity[a.ghost];
    const Vector& n = ghosts.normal[a.ghost];
    total += weight;
    plane.distance += weight * n.dot(x - ghosts.position[a.ghost]);
    plane.before += weight * n.dot(x - ghosts.position[a.ghost] + motion);
    plane.normal += weight * n;
    plane.drift += weight * motion;
    shares.push_back({a.ghost, weight});
  }
  for (std::size_t s = first_share; s < shares.size(); ++s) shares[s].share /= total;
  plane.normal.normalize();
  plane.distance /= total, plane.before /= total, plane.drift /= total;
  return plane;
}

/// Contacts of the particle of candidates [first, last): one with each side of the skin that they make.
void Contacts::touchSkin(const Particles& particles, const VectorField& guess, const Ghosts& ghosts, float dt,
                         std::size_t first, std::size_t last, Found& found) const {
  const std::uint32_t i = candidates_[first].particle;
  const Vector x = particles.position.at(i), u = guess.at(i);
  thread_local std::vector<Candidate> side, rest;
  rest.assign(candidates_.begin() + first, candidates_.begin() + last);
  while (!rest.empty()) {
    takeSide(ghosts, rest, side);
    Contact contact;
    contact.particle = i, contact.solid = Contact::skin;
    contact.first_ghost = static_cast<std::uint32_t>(found.shares.size());
    contact.ghost_count = static_cast<std::uint32_t>(side.size());
    const SkinPlane plane = planeOf(ghosts, side, x, dt, found.shares);
    contact.normal = plane.normal;
    contact.drift = plane.drift;
    const float allowance = std::max(0.5f * spacing_ - plane.before - recovery_speed * dt, 0.0f);
    contact.gap = 0.5f * spacing_ - plane.distance - allowance;
    if (contact.normal.dot(u) < contact.gap + margin * spacing_)
      found.contacts.push_back(contact);
    else
      found.shares.resize(contact.first_ghost);
  }
}

void Contacts::detectSolids(const Particles& particles, const VectorField& guess,
                            const std::vector<Solid>& solids, const std::vector<Eigen::Isometry3d>& start,
                            const std::vector<Eigen::Isometry3d>& end, float dt) {
  constexpr std::size_t chunk_size = 256;
  const std::size_t n = particles.size();
  for (std::size_t s = 0; s < solids.size(); ++s) {
    const Eigen::Isometry3d to_start = start[s].inverse(), to_end = end[s].inverse();
    found_.resize((n + chunk_size - 1) / chunk_size);
    parallelFor(found_.size(), 1, [&](std::size_t c) {
      found_[c].contacts.clear();
      for (std::size_t i = c * chunk_size; i < std::min(n, (c + 1) * chunk_size); ++i) {
        const Vector x = particles.position.at(i);
        const Eigen::Vector3d local = to_start * x.cast<double>();
        const Eigen::Vector3d motion = to_end * (x + guess.at(i)).cast<double>() - local;
        SurfacePoint touch = surface(solids[s], local);
        // No point of a surface comes nearer than the particle moves against it.
        const double near = (0.5 + margin) * spacing_, way = motion.norm();
        if (touch.distance - way > near) continue;
        // Where the particle first comes near, so that nothing is passed by however thin it is.
        Eigen::Vector3d at = local;
        for (double gone = 0.0; touch.distance > near && gone < way;) {
          gone = std::min(gone + std::max(touch.distance - near, 0.01 * spacing_), way);
          at = local + gone / way * motion;
          touch = surface(solids[s], at);
        }
        if (touch.distance > near) continue;
        const double distance = touch.distance + touch.normal.dot(local - at);  // of the start, to that side
        Contact contact;
        contact.particle = static_cast<std::uint32_t>(i), contact.solid = static_cast<std::uint32_t>(s);
        contact.normal = (end[s].linear() * touch.normal).cast<float>();
        contact.drift = (end[s] * local).cast<float>() - x;
        const double allowance = std::max(0.5 * spacing_ - distance - recovery_speed * dt, 0.0);
        contact.gap =
            static_cast<float>(0.5 * spacing_ - distance - allowance) + contact.normal.dot(contact.drift);
        if (contact.normal.dot(guess.at(i)) < contact.gap + margin * spacing_)
          found_[c].contacts.push_back(contact);
      }
    });
    for (const Found& found : found_)
      contacts_.insert(contacts_.end(), found.contacts.begin(), found.contacts.end());
  }
}

std::size_t Contacts::firstOf(std::uint32_t particle) const {
  return std::lower_bound(contacts_.begin(), contacts_.end(), particle,
                          [](const Contact& c, std::uint32_t p) { return c.particle < p; }) -
         contacts_.begin();
}

/// Whether there is a contact of the same particle with the same solid.
bool Contacts::isListed(const Contact& contact) const {
  for (auto at = contacts_.begin() + firstOf(contact.particle);
       at != contacts_.end() && at->particle == contact.particle; ++at)
    if (at->solid == contact.solid) return true;
  return false;
}

/// Where particle i ends in the skin: its tangent plane there, for the contact with that side.
void Contacts::strayIntoSkin(const Particles& particles, const Ghosts& ghosts, std::uint32_t i,
                             const VectorField& u, float dt, Found& found) {
  const float radius = reach * spacing_;
  const Vector x = particles.position.at(i), end = x + u.at(i);
  thread_local std::vector<Candidate> side, rest;
  rest.clear();
  for (std::size_t g = 0; g < ghosts.size(); ++g) {
    const float square = (end - ghosts.position[g]).squaredNorm();
    const Vector before = ghosts.position[g] - dt * ghosts.velocity[g];
    if (square < radius * radius && ghosts.normal[g].dot(x - before) >= -capture * spacing_)
      rest.push_back({i, static_cast<std::uint32_t>(g), square});
  }
  while (!rest.empty()) {
    takeSide(ghosts, rest, side);
    const std::size_t first_share = found.shares.size();
    const SkinPlane plane = planeOf(ghosts, side, end, dt, found.shares);
    const float depth = 0.5f * spacing_ - plane.distance, gap = depth + plane.normal.dot(u.at(i));
    const bool inside = depth > 0.0f && depth < (0.5f + capture) * spacing_;
    Contact* same = nullptr;
    for (auto at = contacts_.begin() + firstOf(i); inside && at != contacts_.end() && at->particle == i; ++at)
      if (at->solid == Contact::skin && at->normal.dot(plane.normal) > same_side) same = &*at;
    if (inside && same == nullptr) {
      Contact contact;
      contact.particle = i, contact.normal = plane.normal, contact.gap = gap;
      contact.first_ghost = static_cast<std::uint32_t>(first_share);
      contact.ghost_count = static_cast<std::uint32_t>(side.size());
      contact.drift = contact.anchor = plane.drift;
      contact.stiffness = leastStiffness(contact, particles, dt);
      found.contacts.push_back(contact);
      continue;
    }
    found.shares.resize(first_share);
    if (!inside) continue;
    same->normal = plane.normal, same->gap = gap;
    same->friction = tangential(same->friction, plane.normal);
    found.turned = true;
  }
}

/// What is struck goes where nothing led to at the start of the step.
bool Contacts::detectStrays(const Particles& particles, const Ghosts& ghosts, const VectorField& u,
                            float dt) {
  constexpr std::size_t chunk_size = 256;
  const std::size_t n = particles.size();
  const float foreseen = margin * spacing_;
  found_.resize((n + chunk_size - 1) / chunk_size);
  parallelFor(found_.size(), 1, [&](std::size_t chunk) {
    found_[chunk].contacts.clear(), found_[chunk].shares.clear();
    found_[chunk].turned = false;
    for (std::size_t i = chunk * chunk_size; i < std::min(n, (chunk + 1) * chunk_size); ++i) {
      if (!((u.at(i) - guess_->at(i)).squaredNorm() > foreseen * foreseen)) continue;
      for (std::size_t s = 0; s < solids_.size(); ++s) {
        Contact contact;
        contact.particle = static_cast<std::uint32_t>(i), contact.solid = static_cast<std::uint32_t>(s);
        if (isListed(contact)) continue;
        const Eigen::Vector3d end = (particles.position.at(i) + u.at(i)).cast<double>();
        const SurfacePoint touch = surface(solids_[s], solids_end_[s].inverse() * end);
        const float depth = 0.5f * spacing_ - static_cast<float>(touch.distance);
        if (!(depth > 0.0f)) continue;
        contact.normal = (solids_end_[s].linear() * touch.normal).cast<float>();
        contact.gap = depth + contact.normal.dot(u.at(i));
        contact.stiffness = leastStiffness(contact, particles, dt);
        found_[chunk].contacts.push_back(contact);
      }
      strayIntoSkin(particles, ghosts, static_cast<std::uint32_t>(i), u, dt, found_[chunk]);
    }
  });
  bool turned = false;
  const std::size_t led_to = contacts_.size();
  for (const Found& found : found_) {
    turned = turned || found.turned;
    add(found);
  }
  if (contacts_.size() == led_to) return turned;
  sortContacts();
  return true;
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

void Contacts::recall(const Particles& particles, float dt) {
  auto from = previous_.cbegin();
  for (Contact& c : contacts_) {
    c.anchor = c.drift;
    c.stiffness = leastStiffness(c, particles, dt);
    while (from != previous_.cend() && from->particle < c.particle) ++from;
    for (auto old = from; old != previous_.cend() && old->particle == c.particle; ++old) {
      if (old->state == Contact::State::open || old->solid != c.solid ||
          old->normal.dot(c.normal) <= same_side)
        continue;
      c.state = old->state;
      c.stiffness = old->stiffness;
      c.density = old->density;
      c.anchor = old->anchor + c.drift;
      c.friction = tangential(old->friction, c.normal);
      // What no longer opposes the motion would push.
      if (c.state == Contact::State::slide && !(c.friction.dot(guess_->at(c.particle) - c.drift) < 0.0f))
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
    u += (c.gap - c.normal.dot(u)) / size * q;
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

template <typename F>
void Contacts::forFilters(std::size_t first, std::size_t last, const F& f) const {
  auto at = std::lower_bound(filters_.begin(), filters_.end(), first,
                             [](const Filter& a, std::size_t particle) { return a.particle < particle; });
  for (; at != filters_.end() && at->particle < last; ++at) f(*at);
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

bool Contacts::update(const Particles& particles, const VectorField& u, const VectorField& residual) {
  std::atomic<bool> changed{false};
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    const Filter& filter = filters_[f];
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
  return changed;
}

void Contacts::expel(const Particles& particles, VectorField& u, float dt) {
  parallelFor(filters_.size(), 64, [&](std::size_t f) {
    const std::uint32_t i = filters_[f].particle;
    const float mass = 1.0f / particles.inverse_mass[i];
    Vector step = u.at(i);
    for (std::uint32_t k = filters_[f].first; k < filters_[f].last; ++k) {
      Contact& c = contacts_[k];
      const float depth = c.gap - c.normal.dot(step);
      if (depth <= 0.0f) continue;
      step += depth * c.normal;
      c.force += mass / (dt * dt) * depth * c.normal;
      if (c.state == Contact::State::open) c.state = Contact::State::slide;
    }
    u.set(i, step);
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
