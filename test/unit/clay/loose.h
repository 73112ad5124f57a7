#pragma once

#include <utility>
#include <vector>

#include "clay/contact/contacts.h"
#include "clouds.h"
#include "support/setups.h"

/// Particles with nothing but contacts, for the tests of contacts.
namespace tactile_clay::clay::loose {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f, particle_mass = 2e-4f;
constexpr float inertia = particle_mass / (dt * dt);
const Eigen::Vector3f gravity(0.0f, 0.0f, -9.81f);

/// Particles that meet nothing but contacts. Their potential is solved to the end in each round, since
/// nothing couples one to the next.
struct Loose {
  Loose(const std::vector<Eigen::Vector3f>& points, float mu)
      : particles(particlesAt(points, particle_mass)),
        near(2.0f * spacing),
        contacts(spacing, {[mu] {
                   Material m;
                   m.friction = m.skin_friction = mu;
                   return m;
                 }()}),
        push(zeros(points.size())) {}

  void step(Skin skin, const std::vector<Solid>& solids, int rounds = 4) {
    samples = std::move(skin);
    const std::size_t n = particles.size();
    free = zeros(n);
    for (std::size_t i = 0; i < n; ++i) {
      free.set(i, dt * particles.velocity.at(i) + dt * dt / particle_mass * push.at(i));
    }
    std::vector<Eigen::Isometry3d> start, end;
    for (const Solid& s : solids) {
      start.push_back(s.pose);
      end.push_back(poseAfter(s, dt));
    }
    near.build(particles.position);
    contacts.detect(near, particles, free, {samples, solids, start, end, dt});
    u = free;
    for (int k = 0; k < rounds; ++k) {
      contacts.prescribe(u);
      VectorField z = residual();
      contacts.filter(0, z.size(), z);
      VectorField change = zeros(n);  // of friction, for a unit displacement along z
      contacts.addFrictionChange(z, 0, z.size(), change);
      for (std::size_t i = 0; i < n; ++i) {
        const float zz = z.at(i).squaredNorm();
        if (zz > 0.0f) u.add(i, zz / (inertia * zz - change.at(i).dot(z.at(i))) * z.at(i));
      }
      contacts.update(particles, u, residual());
    }
    contacts.expel(particles, u, dt);
    contacts.release(particles, u, dt);
    contacts.finish(particles, dt);
    for (std::size_t i = 0; i < n; ++i) {
      particles.position.add(i, u.at(i));
      particles.velocity.set(i, u.at(i) / dt);
    }
  }

  VectorField residual() const {
    VectorField r = zeros(particles.size());
    contacts.addFriction(u, 0, u.size(), r);
    for (std::size_t i = 0; i < r.size(); ++i) r.add(i, inertia * (free.at(i) - u.at(i)));
    return r;
  }

  Particles particles;
  Neighbourhood near;
  Skin samples;
  Contacts contacts;
  VectorField push;  // N, on each particle, gravity included
  VectorField free, u;
};

/// Normal and tangential part of a contact's force.
inline std::pair<float, float> parts(const Contact& c) {
  const float normal = c.force.dot(c.normal);
  return {normal, (c.force - normal * c.normal).norm()};
}

inline Skin floorOfSamples(const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) {
  return samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.02, 0.004, velocity);
}

}  // namespace tactile_clay::clay::loose
