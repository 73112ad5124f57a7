#include "clay/forces/boundary_density.h"

#include <algorithm>

#include "clay/lattice.h"

namespace tactile_clay::clay {

BoundaryDensity::BoundaryDensity(const Kernel& kernel, float spacing, const std::vector<Material>& materials)
    : wall_share_(wallShare(kernel, spacing)) {
  for (const Material& m : materials) packs_.push_back(m.stiffness == 0.0 && m.bulk_modulus > 0.0);
}

const std::vector<BoundaryDensity::Share>& BoundaryDensity::update(const Particles& particles,
                                                                   const std::vector<float>& ratio,
                                                                   const std::vector<Contact>& contacts) {
  const auto counts = [](const Contact& c) {
    return c.solid != Contact::skin && c.state != Contact::State::open;
  };
  shares_.clear();
  if (std::find(packs_.begin(), packs_.end(), true) == packs_.end()) return shares_;
  for (std::size_t first = 0, last; first < contacts.size(); first = last) {
    const std::uint32_t i = contacts[first].particle;
    float left = 1.0f, kept = 0.0f;
    for (last = first; last < contacts.size() && contacts[last].particle == i; ++last) {
      if (!counts(contacts[last])) continue;
      float own_side = 1.0f;
      for (std::size_t k = first; k < last; ++k) {
        const float alike = counts(contacts[k]) ? contacts[last].normal.dot(contacts[k].normal) : 0.0f;
        if (alike > 0.0f) own_side = std::min(own_side, 1.0f - alike * alike);
      }
      left *= 1.0f - wall_share_ * own_side;
      kept = std::max(kept, contacts[last].density);
    }
    if (left == 1.0f || !packs_[particles.material[i]]) continue;
    const float share = std::min(1.0f - left, std::max(kept, 1.0f - ratio[i]));
    if (!(share > 0.0f)) continue;
    shares_.push_back({i, share});
  }
  return shares_;
}

}  // namespace tactile_clay::clay
