#include "clay/bonds.h"

#include <algorithm>
#include <limits>

#include "clay/lanes.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

/// Distance and stretch rate |d ln l / dt| of the pairs of particles [first, last), written from 0 on.
TACTILE_CLAY_MULTIVERSION
void stretchRates(const Neighbourhood& near, const float* velocity, std::size_t first, std::size_t last,
                  float* distance, float* rate) {
  const std::uint32_t* begin = near.begins();
  for (std::size_t i = first; i < last; ++i) {
    const Lane vx = all(velocity[4 * i]), vy = all(velocity[4 * i + 1]), vz = all(velocity[4 * i + 2]);
    for (std::uint32_t p = begin[i]; p < begin[i + 1]; p += lane_width) {
      const LaneVector of_other = gather(velocity, near.other().data() + p);
      const Lane x = load(near.x() + p), y = load(near.y() + p), z = load(near.z() + p);
      const Lane square = x * x + y * y + z * z;
      const Lane opening = (vx - of_other.x) * x + (vy - of_other.y) * y + (vz - of_other.z) * z;
      store(distance + (p - begin[first]), root(square));
      store(rate + (p - begin[first]), (opening < 0.0f ? -opening : opening) / square);
    }
  }
}

}  // namespace

Bonds::Bonds(float spacing, const std::vector<Material>& materials)
    : reach_(1.5f * spacing), materials_(materials.size()) {
  for (const Material& a : materials) {
    for (const Material& b : materials) {
      const double yield = std::min(a.yield_strain, b.yield_strain);
      rules_.push_back(
          {static_cast<float>(std::min(a.stiffness, b.stiffness) * spacing),
           static_cast<float>(std::min(a.bond_rate, b.bond_rate)),
           static_cast<float>(std::min(a.unbond_rate, b.unbond_rate)),
           static_cast<float>(1.0 / (1.0 + yield)),
           yield < 1.0 ? static_cast<float>(1.0 / (1.0 - yield)) : std::numeric_limits<float>::max()});
    }
  }
}

void Bonds::updateIn(Chunk& chunk, const Neighbourhood& near, const Particles& particles, std::size_t first,
                     std::size_t last) {
  const std::size_t pairs = near.padded(last - 1) - near.begin(first);
  thread_local std::vector<float> distances, rates;
  distances.resize(pairs), rates.resize(pairs);
  stretchRates(near, particles.velocity.data(), first, last, distances.data(), rates.data());
  // Of each particle that this one is bonded to: its bond and one; 0: none. All zero between particles.
  thread_local std::vector<std::uint32_t> bond_to;
  if (bond_to.size() < particles.size()) bond_to.resize(particles.size(), 0);
  if (chunk.bonds.size() < pairs) chunk.bonds.resize(pairs);
  chunk.size = 0;
  for (std::size_t i = first; i < last; ++i) {
    for (std::uint32_t b = begin_[i]; b < begin_[i + 1]; ++b) bond_to[bonds_[b].other] = b + 1;
    const PairRule* rules = &rules_[particles.material[i] * materials_];
    const float* distance = &distances[near.begin(i) - near.begin(first)];
    const float* rate = &rates[near.begin(i) - near.begin(first)];
    const std::size_t before = chunk.size;
    for (std::uint32_t p = near.begin(i); p < near.end(i); ++p, ++distance, ++rate) {
      const std::uint32_t j = near.other()[p];
      const PairRule& pair = materials_ == 1 ? *rules : rules[particles.material[j]];
      const std::uint32_t bond = bond_to[j];
      const bool bonded = bond != 0;
      // A bond that is strained beyond its yield has flowed: its elastic strain is on the yield surface.
      const float length = *distance;
      const float rest = bonded ? bonds_[bond - 1].rest_length : length;
      const float flowed = std::min(std::max(rest, length * pair.shortest), length * pair.longest);
      const bool holds =
          (bonded & (*rate <= pair.unbond_rate)) | (!bonded & (length < reach_) & (*rate < pair.bond_rate));
      chunk.bonds[chunk.size] = {j, flowed};
      chunk.size += static_cast<std::size_t>(holds & (length > 0.0f) & (pair.stiffness > 0.0f));
    }
    for (std::uint32_t b = begin_[i]; b < begin_[i + 1]; ++b) bond_to[bonds_[b].other] = 0;
    chunk.count[i - first] = static_cast<std::uint32_t>(chunk.size - before);
  }
}

void Bonds::update(const Neighbourhood& near, const Particles& particles) {
  const std::size_t n = particles.size();
  begin_.resize(n + 1, 0);
  chunks_.resize((n + chunk_size - 1) / chunk_size);
  parallelFor(chunks_.size(), 1, [&](std::size_t c) {
    updateIn(chunks_[c], near, particles, c * chunk_size, std::min(n, (c + 1) * chunk_size));
  });
  for (std::size_t i = 0; i < n; ++i)
    begin_[i + 1] = begin_[i] + chunks_[i / chunk_size].count[i % chunk_size];
  bonds_.resize(begin_[n]);
  parallelFor(chunks_.size(), 1, [&](std::size_t c) {
    std::copy_n(chunks_[c].bonds.begin(), chunks_[c].size, bonds_.begin() + begin_[c * chunk_size]);
  });
}

}  // namespace tactile_clay::clay
