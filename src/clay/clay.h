#pragma once

#include <memory>
#include <string>
#include <vector>

#include "clay/ghosts.h"
#include "clay/material.h"
#include "clay/particles.h"
#include "clay/solid.h"

namespace tactile_clay::clay {

/// How much is spent on a frame. What it buys stands in doc/method.md.
struct Budget {
  int substeps = 4;    // of a frame
  int iterations = 4;  // of all constraints in a substep
};

struct ClayConfig {
  double spacing = 0.005;                        // m, between particles of the initial lattice
  double frame = 1.0 / 60.0;                     // s; frame / substeps is the fixed time step
  Budget budget;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};      // m/s^2
  double world = 1.0;                            // m, half extent of the cube that particles cannot leave
  int threads = 0;                               // 0: as many as there are cores
};

/// Particles to start from.
struct InitialParticle {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f velocity;  // m/s
  std::uint8_t material = 0;
  std::uint16_t body = 0;
};

struct Stage {
  std::string name;
  double ms = 0.0;  // of the last frame
};

struct Statistics {
  std::uint64_t step = 0;  // frames since the start
  std::size_t bonds = 0;
  std::size_t contacts = 0;            // with ghosts and solids, last substep
  double density_error_mean = 0.0;     // of max(rho / rho0 - 1, 0)
  double density_error_max = 0.0;
  std::vector<Stage> stages;
};

/// The clay: Algorithm 1 of the paper with density, viscosity, elastoplastic bonds, impenetrability and friction.
/// The same calls give the same bits, for any number of threads.
class Clay {
 public:
  /// \throws std::invalid_argument naming the parameter, its value and its range
  Clay(const ClayConfig& config, std::vector<Material> materials, std::vector<InitialParticle> particles);
  ~Clay();

  /// Advances by `duration` s in whole time steps; what remains is carried into the next call. At least one step
  /// is made if `duration` >= half a time step was due. Solids move with their velocities from their poses.
  void advance(const Ghosts& ghosts, const std::vector<Solid>& solids, double duration);

  const ClayConfig& config() const;
  const std::vector<Material>& materials() const;
  const Particles& particles() const;
  double time() const;  // s, simulated

  /// Mean force on each touched ghost over the last `advance`, by ascending ghost.
  const std::vector<GhostForce>& ghostForces() const;
  /// Mean force and torque-free sum on each solid over the last `advance`, N.
  const std::vector<Eigen::Vector3d>& solidForces() const;
  const Statistics& statistics() const;

 private:
  struct Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace tactile_clay::clay
