#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace tactile_clay::clay {

/// Where a particle may touch one side of a collider in a step: n . u >= gap. ContactSearch finds it, and it
/// stays in the step.
struct ContactGeometry {
  static constexpr std::uint32_t skin = 0xffffffffu;
  static constexpr float same_side = 0.2f;  // cosine between normals, above which both are of one side

  std::uint32_t particle = 0;
  std::uint32_t solid = skin;                        // index of the solid, or `skin`
  float gap = 0.0f;                                  // m, minimum displacement along the normal
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, out of the collider
  Eigen::Vector3f drift = Eigen::Vector3f::Zero();   // m, displacement of the collider there in this step
  std::uint32_t first_sample = 0, sample_count = 0;  // of a skin contact, in the shares listed beside it

  /// m, by which the displacement u of the particle violates it.
  float depth(const Eigen::Vector3f& u) const { return gap - normal.dot(u); }
  /// What of a vector is along the surface.
  Eigen::Vector3f along(const Eigen::Vector3f& v) const { return v - v.dot(normal) * normal; }
};

/// What a contact knows from the step before, and keeps for the next. Contacts writes it at the start and at
/// the end of a step.
struct ContactMemory {
  Eigen::Vector3f anchor = Eigen::Vector3f::Zero();  // m, from the particle before the step; after it, from
                                                     // the particle then
  float stiffness = 0.0f;                            // N/m, of the friction spring
  float density = 0.0f;                              // of rho_0, see BoundaryDensity
};

/// What a contact does in a step. The solver writes it.
struct ContactResult {
  enum class State : std::uint8_t { open, slide, stick };

  State state = State::open;
  Eigen::Vector3f friction = Eigen::Vector3f::Zero();  // N, tangential force on the particle while it slides
  Eigen::Vector3f force = Eigen::Vector3f::Zero();     // N, on the particle, this step
  float damping = 0.0f;  // N/m, of the friction of a slide; 0: it is `friction`, whatever the slip
  float paid = 0.0f;     // J, at the end of the step: what the friction spring may store
};

/// Contact of a particle with one side of a collider: impenetrability, and friction.
struct Contact : ContactGeometry, ContactMemory, ContactResult {};

/// A sample's share in a contact.
struct SampleShare {
  std::uint32_t sample;
  float share;  // the shares of a contact add up to one
};

}  // namespace tactile_clay::clay
