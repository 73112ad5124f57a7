#include "clay/contact/skin_candidates.h"

#include "clay/threads.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr std::size_t samples_a_chunk = 256;  // that a thread takes at a time

using Vector = Eigen::Vector3f;

struct Passed {               // a sample that particles may pass
  Vector at, motion, normal;  // m, at the start of the step; m, in the step; unit
  float radius, clearance;    // m
};

/// Which of the eight particles from place k on come within the radius of a sample at some time of the step,
/// and started in front of it or at most the radius behind it. A particle within `clearance` of the surface
/// counts as where its contact puts it, at the clearance: else a particle at the rim of the skin would come
/// into reach by going in, and out of reach again by being pushed out, in each second step. Products are
/// summed in the order of Eigen.
/// @param nearest gets the minimum squared distances in the step, m^2
TACTILE_CLAY_MULTIVERSION
unsigned passing(const Passed& sample, const Neighbourhood::Places& places, std::uint32_t k,
                 const float* displacements, float* nearest) {
  const LaneVector r{load(places.x + k) - sample.at[0], load(places.y + k) - sample.at[1],
                     load(places.z + k) - sample.at[2]};
  const LaneVector u = gather(displacements, places.slot + k);
  const LaneVector approach{u.x - sample.motion[0], u.y - sample.motion[1], u.z - sample.motion[2]};
  const Lane square = approach.x * approach.x + (approach.y * approach.y + approach.z * approach.z);
  const Lane along = r.x * approach.x + (r.y * approach.y + r.z * approach.z);
  const Lane t = square > 0.0f ? min(positive(-along / square), all(1.0f)) : Lane{};
  const LaneVector then{r.x + t * approach.x, r.y + t * approach.y, r.z + t * approach.z};
  const Lane distance = then.x * then.x + (then.y * then.y + then.z * then.z);
  const Lane height = r.x * sample.normal[0] + (r.y * sample.normal[1] + r.z * sample.normal[2]);
  const Lane last = then.x * sample.normal[0] + (then.y * sample.normal[1] + then.z * sample.normal[2]);
  const Lane placed = distance + positive(sample.clearance * sample.clearance - last * last);
  store(nearest, placed);
  return bits((placed < sample.radius * sample.radius) & (height >= -sample.radius));
}

Eigen::AlignedBox3f boxOf(const VectorField& field) {
  Eigen::Vector4f minimum = field.size() > 0 ? field[0] : Eigen::Vector4f::Zero(), maximum = minimum;
  for (std::size_t i = 0; i < field.size(); ++i) {
    minimum = minimum.cwiseMin(field[i]);
    maximum = maximum.cwiseMax(field[i]);
  }
  return {minimum.head<3>(), maximum.head<3>()};
}

}  // namespace

void SkinCandidates::find(const Neighbourhood& near, const VectorField& u, const Skin& skin, float dt) {
  const Neighbourhood::Places places = near.places();
  const Eigen::AlignedBox3f ways = boxOf(u);
  const Vector around = Vector::Constant(radius_);
  found_.resize((skin.size() + samples_a_chunk - 1) / samples_a_chunk);
  parallelRanges(skin.size(), samples_a_chunk, [&](std::size_t first, std::size_t last) {
    std::vector<Candidate>& found = found_[first / samples_a_chunk];
    found.clear();
    for (auto g = static_cast<std::uint32_t>(first); g < last; ++g) {
      const Vector motion = dt * skin.velocity[g];
      const Passed sample{skin.position[g] - motion, motion, skin.normal[g], radius_, clearance_};
      const Vector low = sample.at + (motion - ways.max()).cwiseMin(0.0f) - around;
      const Vector high = sample.at + (motion - ways.min()).cwiseMax(0.0f) + around;
      near.forEachRun(low, high, [&](std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t k = from; k < to; k += lane_width) {
          float nearest[lane_width];
          unsigned hits = passing(sample, places, k, u.data(), nearest);
          if (to - k < lane_width) hits &= (1u << (to - k)) - 1u;
          for (; hits != 0; hits &= hits - 1u) {
            const int lane = __builtin_ctz(hits);
            found.push_back({places.slot[k + lane] / slot_size, {g, nearest[lane]}});
          }
        }
      });
    }
  });
  sort(u.size());
}

void SkinCandidates::sort(std::size_t particles) {
  end_.assign(particles + 1, 0);
  for (const std::vector<Candidate>& chunk : found_)
    for (const Candidate& c : chunk) ++end_[c.particle + 1];
  for (std::size_t i = 0; i < particles; ++i) end_[i + 1] += end_[i];
  sorted_.resize(end_.back());
  for (const std::vector<Candidate>& chunk : found_)
    for (const Candidate& c : chunk) sorted_[end_[c.particle]++] = c.near;
}

}  // namespace tactile_clay::clay
