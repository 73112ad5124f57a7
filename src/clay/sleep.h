#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "clay/contact/colliders.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// Clay that has come to rest sleeps: it is left out of the solver, and costs nothing, until something comes
/// near. Lumps sleep and wake as a whole, so no force acts between sleeping and awake clay.
///
/// A lump falls asleep when none of its particles has moved by more than 1e-4 spacings in half a second. At
/// this speed clay would creep by a tenth of a spacing in eight minutes. A lump wakes when a sample, another
/// particle or a moving solid could touch it in the step. It also wakes when a solid at the lump was moved
/// since the last step, or when the number of solids has changed.
class Sleep {
 public:
  /// What is remembered between frames.
  struct State {
    std::vector<std::uint32_t> lump;  // number of each particle's sleeping lump; 0: awake
    VectorField mark;                 // m, position of each particle when the half second began
    double watched = 0.0;             // s, elapsed part of the half second
  };

  /// @param spacing m
  /// @param minimum particles that a lump must have to sleep; smaller lumps are cheaper awake
  Sleep(float spacing, std::size_t minimum) : spacing_(spacing), minimum_(minimum) {}

  const State& state() const { return state_; }
  /// @param particles all particles, awake or asleep
  void restore(State state, const Particles& particles);

  std::size_t lumps() const { return lumps_.size(); }  // number of lumps that are asleep
  std::vector<std::uint32_t> awake() const;            // indices of awake particles, ascending

  /// Wakes the lumps that may be touched in a step.
  /// @param all all particles
  /// @param awake the awake particles
  /// @param around the colliders of the step
  /// @return whether any clay woke
  bool wake(const Particles& all, const Particles& awake, const Surroundings& around);

  /// To be called after the last step of a frame. Puts lumps to sleep that have been at rest for half a
  /// second.
  /// @param awake the awake particles
  /// @param near their neighbourhood, with their lumps
  /// @param around the colliders of the step
  /// @param duration s, of the frame
  /// @return whether any clay fell asleep
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
  std::vector<Eigen::Isometry3d> poses_;  // of the solids, in the last call of `wake`
};

}  // namespace tactile_clay::clay
