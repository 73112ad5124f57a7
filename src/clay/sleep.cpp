#include "clay/sleep.h"

#include <algorithm>
#include <utility>

namespace tactile_clay::clay {
namespace {

constexpr double patience = 0.5;  // s without motion, before clay falls asleep
constexpr float still = 1e-4f;    // spacings; a shorter motion counts as rest. Clay at rest trembles by 1e-6.
constexpr float reach = 2.0f;     // spacings, the support radius; skin acts from a smaller distance
constexpr float pull = 10.0f;     // m/s^2, acceleration that an awake particle may get
constexpr float elsewhere = 1e6f;  // m, mark of a particle that has just woken: it then counts as moved

}  // namespace

void Sleep::restore(State state, const Particles& particles) {
  state_ = std::move(state);
  lumps_.clear();
  const std::uint32_t maximum =
      state_.lump.empty() ? 0 : *std::max_element(state_.lump.begin(), state_.lump.end());
  std::vector<Lump> all(maximum);
  for (std::uint32_t i = 0; i < state_.lump.size(); ++i) {
    if (state_.lump[i] == 0) continue;
    Lump& lump = all[state_.lump[i] - 1];
    lump.number = state_.lump[i];
    lump.box.extend(particles.position.at(i));
    lump.members.push_back(i);
  }
  for (Lump& lump : all)
    if (!lump.members.empty()) lumps_.push_back(std::move(lump));
}

std::vector<std::uint32_t> Sleep::awake() const {
  std::vector<std::uint32_t> list;
  for (std::uint32_t i = 0; i < state_.lump.size(); ++i)
    if (state_.lump[i] == 0) list.push_back(i);
  return list;
}

/// Box of the places where a particle, and what it reaches, can be in a step.
Sleep::Box Sleep::swept(const Particles& particles, std::size_t i, float dt) const {
  const Eigen::Vector3f x = particles.position.at(i);
  const Eigen::Vector3f room = Eigen::Vector3f::Constant(reach * spacing_ + pull * dt * dt);
  const Eigen::Vector3f next = x + dt * particles.velocity.at(i);
  return {x.cwiseMin(next) - room, x.cwiseMax(next) + room};
}

/// Whether a solid that moves from one pose to the other may touch a lump.
bool Sleep::reached(const Lump& lump, const VectorField& position, const Solid& solid,
                    const Eigen::Isometry3d& start, const Eigen::Isometry3d& end) const {
  const Eigen::Isometry3d to_solid = start.inverse();
  const double way = (end.translation() - start.translation()).norm();
  const double turn = (end.linear() - start.linear()).norm();  // m per metre from its origin, at most
  const auto near = [&](const Eigen::Vector3f& x, double radius) {
    const Eigen::Vector3d local = to_solid * x.cast<double>();
    return surface(solid, local).distance < radius + 1.5 * spacing_ + way + turn * (local.norm() + radius);
  };
  return near(lump.box.center(), 0.5 * lump.box.diagonal().norm()) &&
         std::any_of(lump.members.begin(), lump.members.end(),
                     [&](std::uint32_t i) { return near(position.at(i), 0.0); });
}

/// Whether samples, or solids that move or were moved, may touch a lump.
bool Sleep::disturbed(const Lump& lump, const VectorField& position, const Surroundings& around) const {
  const Eigen::Vector3f room = Eigen::Vector3f::Constant(reach * spacing_);
  const Box box(lump.box.min() - room, lump.box.max() + room);
  const Skin& skin = around.skin;
  for (std::size_t k = 0; k < skin.size(); ++k) {
    const Eigen::Vector3f to = skin.position[k], from = to - around.dt * skin.velocity[k];
    if (box.intersects(Box(from.cwiseMin(to), from.cwiseMax(to)))) return true;
  }
  for (std::size_t s = 0; s < around.solids.size(); ++s) {
    const Eigen::Isometry3d &start = around.start[s], &end = around.end[s];
    const bool moving = start.matrix() != end.matrix();
    const bool moved = s < poses_.size() && !(poses_[s].matrix() - start.matrix()).isZero(1e-9);
    if ((moving || moved) && reached(lump, position, around.solids[s], start, end)) return true;
    if (moved && reached(lump, position, around.solids[s], poses_[s], poses_[s])) return true;
  }
  return !poses_.empty() && poses_.size() != around.solids.size();
}

bool Sleep::wake(const Particles& all, const Particles& awake, const Surroundings& around) {
  std::vector<std::uint32_t> woken;
  for (const Lump& lump : lumps_) {
    bool wakes = disturbed(lump, all.position, around);
    for (std::size_t i = 0; !wakes && i < awake.size(); ++i)
      wakes = lump.box.intersects(swept(awake, i, around.dt));
    if (!wakes) continue;
    woken.push_back(lump.number);
    for (const std::uint32_t i : lump.members) {
      state_.lump[i] = 0;
      state_.mark.set(i, Eigen::Vector3f::Constant(elsewhere));
    }
  }
  poses_ = around.start;
  lumps_.erase(std::remove_if(lumps_.begin(), lumps_.end(),
                              [&](const Lump& lump) {
                                return std::find(woken.begin(), woken.end(), lump.number) != woken.end();
                              }),
               lumps_.end());
  return !woken.empty();
}

bool Sleep::settle(const Particles& at, const Neighbourhood& near, const Surroundings& around,
                   double duration) {
  state_.watched += duration;
  if (state_.watched < patience) return false;
  state_.watched = 0.0;

  const std::vector<std::uint32_t> awake = this->awake();
  std::vector<Lump> candidates(near.lumps());
  std::vector<bool> resting(near.lumps(), true);
  VectorField position = state_.mark;  // of all particles: the mark; of awake particles: the present position
  for (std::uint32_t k = 0; k < awake.size(); ++k) {
    const std::uint32_t i = awake[k];
    const Eigen::Vector3f now = at.position.at(k);
    if (!((now - state_.mark.at(i)).norm() < still * spacing_)) resting[near.lump(k)] = false;
    candidates[near.lump(k)].box.extend(now);
    candidates[near.lump(k)].members.push_back(i);
    position.set(i, now);
  }
  for (std::size_t l = 0; l < candidates.size(); ++l)
    resting[l] =
        resting[l] && candidates[l].members.size() >= minimum_ && !disturbed(candidates[l], position, around);
  // A lump that stays awake keeps awake the lumps that it may reach.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t k = 0; k < awake.size(); ++k) {
      if (resting[near.lump(k)]) continue;
      const Box box = swept(at, k, around.dt);
      for (std::size_t l = 0; l < candidates.size(); ++l) {
        if (!resting[l] || !candidates[l].box.intersects(box)) continue;
        resting[l] = false;
        changed = true;
      }
    }
  }
  std::uint32_t number = 0;
  for (const Lump& lump : lumps_) number = std::max(number, lump.number);
  bool any = false;
  for (std::size_t l = 0; l < candidates.size(); ++l) {
    if (!resting[l]) continue;
    candidates[l].number = ++number;
    for (const std::uint32_t i : candidates[l].members) state_.lump[i] = number;
    lumps_.push_back(std::move(candidates[l]));
    any = true;
  }
  state_.mark = std::move(position);
  return any;
}

}  // namespace tactile_clay::clay
