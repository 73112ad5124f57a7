#include <algorithm>
#include <utility>

#include "clay/clay_state.h"

namespace tactile_clay::clay {

void Clay::State::publishAwake() {
  for (std::size_t k = 0; k < awake.size(); ++k) {
    everyone.position[awake[k]] = particles.position[k];
    everyone.velocity[awake[k]] = particles.velocity[k];
    everyone.density_ratio[awake[k]] = particles.density_ratio[k];
    everyone.compression[awake[k]] = particles.compression[k];
  }
}

Sculpture Clay::State::sculpture() const {
  Sculpture s;
  s.time = time;
  s.carry = carry;
  s.step = statistics.step;
  s.spacing = config.spacing;
  s.position = s.window_start = everyone.position;
  s.velocity = everyone.velocity;
  s.compression = everyone.compression;
  s.density_ratio = everyone.density_ratio;
  s.window_steps = window_steps;
  s.material = everyone.material;
  s.body = everyone.body;
  s.bond_begin = {0};
  s.contacts = sleeping_contacts;
  s.sleep = sleep.state();
  for (std::size_t k = 0; k < awake.size(); ++k) s.window_start[awake[k]] = window_start[k];
  // A hundred and more sculptures are kept for undo, so each takes no more memory than it needs.
  s.bond_begin.reserve(everyone.size() + 1);
  s.bonds.reserve(2 * bond_constraint.size() + sleeping_bonds.size());
  s.contacts.reserve(s.contacts.size() + contact_constraint.contacts().size());
  std::size_t k = 0;
  for (std::size_t i = 0; i < everyone.size(); ++i) {
    if (k < awake.size() && awake[k] == i) {
      for (const Bond* b = bond_constraint.begin(k); b != bond_constraint.end(k); ++b)
        s.bonds.push_back({awake[b->other], b->rest_length});
      ++k;
    } else {
      s.bonds.insert(s.bonds.end(), sleeping_bonds.begin() + sleeping_bond_begin[i],
                     sleeping_bonds.begin() + sleeping_bond_begin[i + 1]);
    }
    s.bond_begin.push_back(static_cast<std::uint32_t>(s.bonds.size()));
  }
  for (Contact c : contact_constraint.contacts()) {
    c.particle = awake[c.particle];
    s.contacts.push_back(c);
  }
  std::stable_sort(s.contacts.begin(), s.contacts.end(),
                   [](const Contact& a, const Contact& b) { return a.particle < b.particle; });
  return s;
}

/// Takes over a sculpture, and separates awake particles from sleeping ones.
void Clay::State::restore(const Sculpture& s) {
  constexpr std::uint32_t nobody = 0xffffffffu;
  time = s.time;
  carry = s.carry;
  statistics.step = s.step;
  window_steps = s.window_steps;
  fresh = true;
  everyone.position = s.position;
  everyone.velocity = s.velocity;
  everyone.compression = s.compression;
  if (!s.density_ratio.empty()) everyone.density_ratio = s.density_ratio;
  sleep.restore(s.sleep, everyone);
  awake = sleep.awake();

  const std::size_t n = everyone.size();
  std::vector<std::uint32_t> index(n, nobody);  // of each particle, in `awake`
  particles = {};
  for (VectorField* field : {&particles.position, &particles.velocity, &window_start, &free, &u})
    field->resize(awake.size());
  for (std::uint32_t k = 0; k < awake.size(); ++k) {
    const std::uint32_t i = awake[k];
    index[i] = k;
    particles.position[k] = everyone.position[i];
    particles.velocity[k] = everyone.velocity[i];
    window_start[k] = s.window_start[i];
    particles.inverse_mass.push_back(everyone.inverse_mass[i]);
    particles.density_ratio.push_back(everyone.density_ratio[i]);
    particles.compression.push_back(everyone.compression[i]);
    particles.material.push_back(everyone.material[i]);
    particles.body.push_back(everyone.body[i]);
  }
  std::vector<std::uint32_t> begins{0};
  std::vector<Bond> awake_bonds;
  sleeping_bond_begin.assign(1, 0);
  sleeping_bonds.clear();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::uint32_t b = s.bond_begin[i]; b < s.bond_begin[i + 1]; ++b) {
      const Bond& bond = s.bonds[b];
      if (index[i] == nobody)
        sleeping_bonds.push_back(bond);
      else if (index[bond.other] != nobody)
        awake_bonds.push_back({index[bond.other], bond.rest_length});
    }
    if (index[i] != nobody) begins.push_back(static_cast<std::uint32_t>(awake_bonds.size()));
    sleeping_bond_begin.push_back(static_cast<std::uint32_t>(sleeping_bonds.size()));
  }
  bond_constraint.restore(begins, std::move(awake_bonds));
  sleeping_contacts.clear();
  std::vector<Contact> contacts;
  for (Contact c : s.contacts) {
    if (index[c.particle] == nobody) {
      sleeping_contacts.push_back(c);
      continue;
    }
    c.particle = index[c.particle];
    contacts.push_back(c);
  }
  contact_constraint.restore(std::move(contacts));
}

/// Separates awake from sleeping particles again, after some clay woke or fell asleep.
void Clay::State::regroup() {
  publishAwake();
  for (std::size_t i = 0; i < everyone.size(); ++i)
    if (sleep.state().lump[i] != 0) everyone.velocity[i].setZero();
  restore(sculpture());
}

}  // namespace tactile_clay::clay
