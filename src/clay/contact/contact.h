#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace tactile_clay::clay {

/// A place where a particle may touch one side of a collider in a step: n . u >= gap. ContactSearch finds it,
/// and it remains for the rest of the step.
struct ContactGeometry {
  static constexpr std::uint32_t skin = 0xffffffffu;
  static constexpr float same_side = 0.2f;  // cosine between two normals, above which they belong to one side

  std::uint32_t particle = 0;
  std::uint32_t solid = skin;                        // index of the solid, or `skin`
  float gap = 0.0f;                                  // m, minimum displacement along the normal
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, out of the collider
  Eigen::Vector3f drift = Eigen::Vector3f::Zero();   // m, displacement of the collider there in this step
  std::uint32_t first_sample = 0, sample_count = 0;  // of a skin contact, in the list of SampleShare

  /// Depth by which the displacement u of the particle violates the contact, m.
  float depth(const Eigen::Vector3f& u) const { return gap - normal.dot(u); }
  /// The part of a vector along the surface.
  Eigen::Vector3f along(const Eigen::Vector3f& v) const { return v - v.dot(normal) * normal; }
};

/// State of a contact that is kept from step to step. Class Contacts writes it at the start and at the end of
/// a step.
struct ContactMemory {
  // m, from the particle at the start of the step; after the step, from the particle at its end.
  Eigen::Vector3f anchor = Eigen::Vector3f::Zero();
  float stiffness = 0.0f;  // N/m, of the friction spring
  float density = 0.0f;    // in units of rho_0, see BoundaryDensity
};

/// What a contact does in a step. The solver writes it.
struct ContactResult {
  enum class State : std::uint8_t { open, slide, stick };

  State state = State::open;
  Eigen::Vector3f friction = Eigen::Vector3f::Zero();  // N, tangential force on the particle while it slides
  Eigen::Vector3f force = Eigen::Vector3f::Zero();     // N, on the particle, this step
  float damping = 0.0f;  // N/m, of friction while sliding; 0: it is `friction`, whatever the slip
  float paid = 0.0f;     // J, maximum energy of the friction spring at the end of the step
};

/// Contact of a particle with one side of a collider: impenetrability, and friction.
struct Contact : ContactGeometry, ContactMemory, ContactResult {};

/// A sample's share in a contact.
struct SampleShare {
  std::uint32_t sample;
  float share;  // the shares of a contact add up to one
};

}  // namespace tactile_clay::clay
