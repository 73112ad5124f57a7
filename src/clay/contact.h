#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace tactile_clay::clay {

/// Contact of a particle with one side of an obstacle during a step: n . u >= gap (impenetrability), and
/// friction.
struct Contact {
  enum class State : std::uint8_t { open, slide, stick };
  static constexpr std::uint32_t skin = 0xffffffffu;
  static constexpr float same_side = 0.2f;  // cosine between normals, above which both are of one side

  std::uint32_t particle = 0;
  std::uint32_t solid = skin;  // index of the solid, or `skin`
  State state = State::open;
  float gap = 0.0f;                                  // m, least displacement along the normal
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, out of the obstacle
  Eigen::Vector3f drift =
      Eigen::Vector3f::Zero();  // m, displacement of the obstacle at the contact in this step
  Eigen::Vector3f anchor = Eigen::Vector3f::Zero();  // m, from the particle before the step; after it, from
                                                     // the particle then
  float stiffness = 0.0f;                            // N/m, of the friction spring
  float damping = 0.0f;  // N/m, of the friction of a slide; 0: it is `friction`, whatever the slip
  float paid = 0.0f;     // J, at the end of the step: what the friction spring may store
  float density = 0.0f;  // of rho_0, see BoundaryDensity
  Eigen::Vector3f friction = Eigen::Vector3f::Zero();  // N, tangential force on the particle while it slides
  Eigen::Vector3f force = Eigen::Vector3f::Zero();     // N, on the particle, this step
  std::uint32_t first_ghost = 0, ghost_count = 0;      // of a skin contact, in the shares listed beside it
};

/// A ghost's share in a contact.
struct GhostShare {
  std::uint32_t ghost;
  float share;  // the shares of a contact add up to one
};

}  // namespace tactile_clay::clay
