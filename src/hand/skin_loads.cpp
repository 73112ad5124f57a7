#include "hand/skin_loads.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3f;

constexpr float strongest = 5.0F;  // N, on one sample
constexpr float weakest = 1e-9F;   // N; a weaker force has no clear direction
// N, on a hand: in one frame, more than leaning on a table, and in the end, more than all its couplings pull
// together. If the limit were lower, the couplings would drive the hand through the clay that stops it.
constexpr float strongest_of_all = 50.0F, strongest_in_the_end = 120.0F;
constexpr float growth = 1.04F;            // per frame, of forces above the first limit
constexpr float friction = 1.0F;           // maximum sideways force of a load, over its force inward
constexpr float softest_clay = 200.0F;     // N/m at one sample
constexpr float stiffest_clay = 10000.0F;  // N/m at one sample
constexpr float first_guess = 1000.0F;     // N/m
constexpr float forgetting = 0.97F;        // factor of the stiffness estimate, per frame
// After the clay has let go of a place, a load of zero force resists motion there, with a share of the clay's
// stiffness. The share falls by this factor in each frame, until it is nearly zero. If it fell more slowly,
// flesh would hover over the clay.
constexpr float forgiving = 0.25F;
constexpr int longest_memory = 4;  // frames
constexpr float newest = 0.8F;     // share of the clay's newest answer in the loads

// Adds up forces on one sample, by rising index. Each is limited so that its norm stays finite.
std::vector<SkinForce> oneASample(std::vector<SkinForce> forces) {
  constexpr float no_matter_how_strong = 1e6F;  // N in each direction, far above `strongest`
  std::stable_sort(forces.begin(), forces.end(),
                   [](const SkinForce& a, const SkinForce& b) { return a.index < b.index; });
  std::vector<SkinForce> sums;
  for (const SkinForce& f : forces) {
    const Vector3f force = f.force.cwiseMax(-no_matter_how_strong).cwiseMin(no_matter_how_strong);
    if (!sums.empty() && sums.back().index == f.index)
      sums.back().force += force;
    else
      sums.push_back({f.index, force});
  }
  return sums;
}

}  // namespace

SkinLoads::SkinLoads(std::vector<FleshPoint> skin) : skin_(std::move(skin)) {
  reset();
}

void SkinLoads::clear() {
  loads_.clear();
  at_.clear();
}

void SkinLoads::reset() {
  clear();
  stiffness_.fill(first_guess);
}

void SkinLoads::give(const std::vector<SkinForce>& given, const std::vector<Vector3f>& at) {
  const std::vector<SkinForce> forces = oneASample(given);
  std::vector<Load> next;
  next.reserve(forces.size());
  float sum = 0.0F, before = 0.0F;
  for (const SkinForce& f : forces) sum += std::min(strongest, f.force.stableNorm());
  for (const Load& load : loads_) before += load.force.norm();
  const float maximum = std::clamp(growth * before, strongest_of_all, strongest_in_the_end);
  const float share = std::min(1.0F, maximum / std::max(sum, 1e-6F));
  for (const SkinForce& f : forces) {
    const int sample = static_cast<int>(f.index);
    const float size = f.force.stableNorm();
    if (size < weakest) continue;
    const Vector3f force = share * std::min(1.0F, strongest / size) * f.force;
    next.push_back({sample, force, force / force.norm(), at[sample], 0, 0.0F, force});
  }
  std::vector<bool> taken(skin_.size(), false);
  for (const Load& load : next) taken[load.sample] = true;
  for (const Load& old : loads_)
    if (!taken[old.sample] && old.age < longest_memory)
      next.push_back(
          {old.sample, Vector3f::Zero(), old.inward, at[old.sample], old.age + 1, 0.0F, Vector3f::Zero()});
  std::sort(next.begin(), next.end(), [](const Load& a, const Load& b) { return a.sample < b.sample; });
  estimateStiffness(next, at);
  average(next, at);
}

// The clay answers moving skin in jolts. Pairs of force and place are averaged; clay at rest is felt as it
// is.
void SkinLoads::average(std::vector<Load>& next, const std::vector<Vector3f>& at) {
  if (at_.size() != at.size()) {
    at_ = at;
  } else {
    std::vector<Vector3f> before(skin_.size(), Vector3f::Zero());
    for (const Load& load : loads_) before[load.sample] = load.force;
    for (std::size_t i = 0; i < at.size(); ++i) at_[i] += newest * (at[i] - at_[i]);
    for (Load& load : next) {
      load.at = at_[load.sample];
      if (load.age > 0) continue;  // a sample that is let go is free at once
      load.force = load.now = (1.0F - newest) * before[load.sample] + newest * load.force;
      load.inward = load.force.stableNormalized();
    }
  }
  loads_ = std::move(next);
}

// Least squares of -df = K dx, along the forces, over the samples of a body that are loaded now or were
// before. The estimate rises at once and falls slowly. If it is too high, the hand only answers late. If it
// is too low, the hand rings.
void SkinLoads::estimateStiffness(const std::vector<Load>& next, const std::vector<Vector3f>& at) {
  std::array<float, body_count> with{}, square{};
  const auto compare = [&](int sample, const Vector3f& before, const Vector3f& now) {
    const Vector3f direction = (before + now).stableNormalized();  // zero if neither presses
    const float dx = direction.dot(at[sample] - at_[sample]);
    const int body = skin_[sample].body;
    with[body] -= dx * direction.dot(now - before);
    square[body] += dx * dx;
  };
  auto old = loads_.cbegin();
  auto fresh = next.cbegin();
  while (at_.size() == at.size() && (old != loads_.cend() || fresh != next.cend())) {
    const int a = old == loads_.cend() ? std::numeric_limits<int>::max() : old->sample;
    const int b = fresh == next.cend() ? std::numeric_limits<int>::max() : fresh->sample;
    compare(std::min(a, b), a <= b ? old->force : Vector3f::Zero(), b <= a ? fresh->force : Vector3f::Zero());
    if (a <= b) ++old;
    if (b <= a) ++fresh;
  }
  for (int b = 0; b < body_count; ++b) {
    if (square[b] < 1e-14F) continue;
    const float estimate = std::max(with[b] / square[b], forgetting * stiffness_[b]);
    stiffness_[b] = std::clamp(estimate, softest_clay, stiffest_clay);
  }
}

void SkinLoads::apply(std::vector<FleshNode>& nodes) {
  for (Load& load : loads_) {
    const FleshPoint& s = skin_[load.sample];
    load.stiffness = stiffness_[s.body] * std::pow(forgiving, static_cast<float>(load.age));
    for (int k = 0; k < 3; ++k) {
      FleshNode& n = nodes[s.node[k]];
      n.head<3>() += n[3] * s.share[k] * load.now;
    }
  }
}

void SkinLoads::project(std::vector<FleshNode>& nodes) {
  for (Load& load : loads_) {
    const FleshPoint& s = skin_[load.sample];
    float w = 0.0F;
    for (int k = 0; k < 3; ++k) w += s.share[k] * s.share[k] * nodes[s.node[k]][3];
    const float compliance = 1.0F / load.stiffness;
    const Vector3f residual = -(s.position(nodes) - load.at) - compliance * (load.now - load.force);
    Vector3f now = load.now + residual / (w + compliance);
    // The load presses or is zero. Sideways it is at most the friction.
    const Vector3f& inward = load.inward;
    const float pressing = now.dot(inward);
    if (pressing <= 0.0F) {
      now.setZero();
    } else {
      const Vector3f aside = now - pressing * inward;
      const float size = aside.norm(), limit = friction * pressing;
      if (size > limit) now = pressing * inward + (limit / size) * aside;
    }
    const Vector3f change = now - load.now;
    load.now = now;
    for (int k = 0; k < 3; ++k) {
      FleshNode& n = nodes[s.node[k]];
      n.head<3>() += n[3] * s.share[k] * change;
    }
  }
}

std::array<bool, body_count> SkinLoads::pressed() const {
  std::array<bool, body_count> pressed{};
  for (const Load& load : loads_) pressed[skin_[load.sample].body] = true;
  return pressed;
}

Eigen::Vector3d SkinLoads::force() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Load& load : loads_) sum += load.now.cast<double>();
  return sum;
}

double SkinLoads::strength() const {
  double sum = 0.0;
  for (const Load& load : loads_) sum += static_cast<double>(load.now.norm());
  return sum;
}

}  // namespace tactile_clay::hand
