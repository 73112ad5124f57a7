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

void Bonds::update(const Neighbourhood& near, const Particles& particles) {
  const std::size_t n = particles.size();
  begin_.resize(n + 1, 0);
  next_begin_.assign(n + 1, 0);

  // Calls keep(j, rest length) for each bond of particle i after the update, in the neighbours' order.
  const auto forEachNext = [&](std::size_t i, const auto& keep) {
    for (std::uint32_t p = near.begin(i); p < near.begin(i) + near.count(i); ++p) {
      const std::uint32_t j = near.other()[p];
      const PairRule& pair = rule(particles.material[i], particles.material[j]);
      if (!(pair.stiffness > 0.0f)) continue;
      const Eigen::Vector3f x = near.offset().at(p);
      const float length = x.norm();
      if (!(length > 0.0f)) continue;
      const auto owned = bonds_.begin() + begin_[i], end = bonds_.begin() + begin_[i + 1];
      const auto bond = std::find_if(owned, end, [j](const Bond& b) { return b.other == j; });
      if (bond == end && length >= reach_) continue;
      const float rate =
          std::abs((particles.velocity.at(i) - particles.velocity.at(j)).dot(x)) / (length * length);
      if (bond != end && rate <= pair.unbond_rate) keep(j, bond->rest_length);
      if (bond == end && rate < pair.bond_rate) keep(j, length);
    }
  };
  parallelFor(n, 256, [&](std::size_t i) {
    std::uint32_t count = 0;
    forEachNext(i, [&](std::uint32_t, float) { ++count; });
    next_begin_[i + 1] = count;
  });
  for (std::size_t i = 0; i < n; ++i) next_begin_[i + 1] += next_begin_[i];
  next_.resize(next_begin_[n]);
  parallelFor(n, 256, [&](std::size_t i) {
    std::uint32_t b = next_begin_[i];
    forEachNext(i, [&](std::uint32_t j, float rest_length) { next_[b++] = {j, rest_length}; });
  });
  bonds_.swap(next_);
  begin_.swap(next_begin_);
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
