#pragma once

#include <vector>

#include "clay/forces/bonds.h"
#include "clouds.h"

namespace tactile_clay::clay::bonds_test {

inline constexpr float spacing = 0.005f;
inline constexpr int edge = 7;  // particles, of lattices whose middle no surface reaches

inline Material testMaterial() {
  Material m;
  m.stiffness = 1e5;
  m.bond_rate = 1.0;
  m.unbond_rate = 10.0;
  m.yield_strain = 0.1;
  return m;
}

/// Particles, and the bonds between them.
struct Bonded {
  explicit Bonded(const std::vector<Eigen::Vector3f>& points,
                  std::vector<Material> materials = {testMaterial()})
      : particles(particlesAt(points, 2e-4f)), bonds(spacing, materials), near(2.0f * spacing) {}

  /// @param duration s, in which stress relaxes
  void update(float duration = 0.0f) {
    near.build(particles.position);
    bonds.update(near, particles, particles.velocity, true, duration);
  }
  const Bond* find(std::uint32_t i, std::uint32_t j) const {
    for (const Bond* b = bonds.begin(i); b != bonds.end(i); ++b) {
      if (b->other == j) return b;
    }
    return nullptr;
  }

  Particles particles;
  Bonds bonds;
  Neighbourhood near;
};

}  // namespace tactile_clay::clay::bonds_test
