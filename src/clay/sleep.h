#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "clay/contact/colliders.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// Clay that has come to rest sleeps: it is left out of the solver, and costs nothing, until something comes
/// near. What sleeps and wakes is a lump, clay within each other's reach, so that no force crosses between
/// what sleeps and what does not.
///
/// A lump falls asleep when none of its particles has moved by more than 1e-4 spacings in half a second: clay
/// that went on like that would creep by a tenth of a spacing in eight minutes. It wakes when a sample,
/// another particle or a moving solid could touch it within the step, and when a solid has moved from its
/// place.
class Sleep {
 public:
  /// What is remembered of each particle.
  struct State {
    std::vector<std::uint32_t> lump;  // number of the sleeping lump; 0: awake
    VectorField mark;                 // m, where it was when the half second began
    double watched = 0.0;             // s, of the half second
  };

  /// @param spacing m
  /// @param minimum particles that a lump must have to sleep; smaller ones are cheaper awake
  Sleep(float spacing, std::size_t minimum) : spacing_(spacing), minimum_(minimum) {}

  const State& state() const { return state_; }
  /// @param particles all of them
  void restore(State state, const Particles& particles);

  std::size_t lumps() const { return lumps_.size(); }  // that are asleep
  std::vector<std::uint32_t> awake() const;            // ascending

  /// Wakes what may be touched in a step.
  /// @return whether any clay woke
  /// @param all particles;
  /// @param awake those that move
  bool wake(const Particles& all, const Particles& awake, const Surroundings& around);

  /// Watches after the last step of a frame.
  /// @return whether any clay fell asleep
  /// @param awake particles, and the lumps they make up;
  /// @param duration s, of the frame
  bool settle(const Particles& awake, const Neighbourhood& near, const Surroundings& around, double duration);

 private:
  using Box = Eigen::AlignedBox3f;
  struct Lump {
    std::uint32_t number;
    Box box;
    std::vector<std::uint32_t> members;
  };
  Box swept(const Particles& particles, std::size_t i, float dt) const;
  bool disturbed(const Lump& lump, const VectorField& position, const Surroundings& around) const;
  bool reached(const Lump& lump, const VectorField& position, const Solid& solid,
               const Eigen::Isometry3d& start, const Eigen::Isometry3d& end) const;

  float spacing_;
  std::size_t minimum_;
  State state_;
  std::vector<Lump> lumps_;
  std::vector<Eigen::Isometry3d> poses_;  // of the solids, as last looked at
};

}  // namespace tactile_clay::clay
