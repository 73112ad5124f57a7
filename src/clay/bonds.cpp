#include "clay/bonds.h"

#include <algorithm>
#include <cmath>

#include "clay/threads.h"

namespace tactile_clay::clay {

Bonds::Bonds(float spacing, const std::vector<Material>& materials)
    : reach_(1.5f * spacing), materials_(materials.size()) {
  for (const Material& a : materials) {
    for (const Material& b : materials) {
      rules_.push_back({static_cast<float>(std::min(a.stiffness, b.stiffness) * spacing),
                        static_cast<float>(std::min(a.bond_rate, b.bond_rate)),
                        static_cast<float>(std::min(a.unbond_rate, b.unbond_rate)),
                        static_cast<float>(std::min(a.yield_strain, b.yield_strain))});
    }
  }
}

void Bonds::updateIn(Chunk& chunk, const Neighbourhood& near, const Particles& particles, std::size_t first,
                     std::size_t last) {
  chunk.bonds.clear();
  for (std::size_t i = first; i < last; ++i) {
    const std::size_t before = chunk.bonds.size();
    for (std::uint32_t p = near.begin(i); p < near.end(i); ++p) {
      const std::uint32_t j = near.other()[p];
      const PairRule& pair = rule(particles.material[i], particles.material[j]);
      if (!(pair.stiffness > 0.0f)) continue;
      const Eigen::Vector3f x = near.offset(p);
      const float square = x.squaredNorm();
      const Bond* bond = std::find_if(begin(i), end(i), [j](const Bond& b) { return b.other == j; });
      const bool bonded = bond != end(i);
      if (!(square > 0.0f) || (!bonded && square >= reach_ * reach_)) continue;
      const float rate = std::abs((particles.velocity.at(i) - particles.velocity.at(j)).dot(x)) / square;
      if (bonded && rate <= pair.unbond_rate) chunk.bonds.push_back(*bond);
      if (!bonded && rate < pair.bond_rate) chunk.bonds.push_back({j, std::sqrt(square)});
    }
    chunk.count[i - first] = static_cast<std::uint32_t>(chunk.bonds.size() - before);
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
    std::copy(chunks_[c].bonds.begin(), chunks_[c].bonds.end(), bonds_.begin() + begin_[c * chunk_size]);
  });
}

void Bonds::flow(const Particles& particles) {
  const VectorField& x = particles.position;
  parallelFor(particles.size(), 256, [&](std::size_t i) {
    for (std::uint32_t b = begin_[i]; b < begin_[i + 1]; ++b) {
      Bond& bond = bonds_[b];
      const float yield = rule(particles.material[i], particles.material[bond.other]).yield_strain;
      const float length = (x.at(i) - x.at(bond.other)).norm();
      // the elastic strain (l - d) / d is brought back to the yield surface
      if (length > (1.0f + yield) * bond.rest_length) bond.rest_length = length / (1.0f + yield);
      if (yield < 1.0f && length < (1.0f - yield) * bond.rest_length)
        bond.rest_length = length / (1.0f - yield);
    }
  });
}

}  // namespace tactile_clay::clay
