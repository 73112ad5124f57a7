#pragma once

#include <memory>
#include <string>
#include <vector>

#include "clay/material.h"
#include "clay/particles.h"
#include "clay/sculpture.h"
#include "clay/solid.h"
#include "values/skin.h"

namespace tactile_clay::clay {

/// @throws std::invalid_argument naming the parameter, its value and its range
void validate(const Material& material);

/// How a time step is solved.
enum class Method {
  minimise,  // the incremental potential, by conjugate gradients (class Minimiser)
  paper      // the paper's projection of one constraint type after the other (class Projection)
};

/// @throws std::invalid_argument if the name is neither `minimise` nor `paper`
Method methodNamed(const std::string& name);

/// How much computing is spent on a frame, and with which method. Accuracy: doc/method/speed_accuracy.md.
struct Budget {
  int substeps = 4;    // time steps per frame
  int iterations = 8;  // per time step, of all constraints together
  Method method = Method::minimise;
};

struct ClayConfig {
  double spacing = 0.005;     // m, between particles of the initial lattice
  double frame = 1.0 / 60.0;  // s
  Budget budget;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  // m/s^2
  double world = 1.0;                        // m, half extent of the cube that particles cannot leave
  double tolerance = 0.01;  // m/s^2, iterations stop when no particle lacks more acceleration
  int threads = 0;          // 0: as many as there are cores
  bool sleeping = true;     // leave clay at rest out of the solver until something comes near (class Sleep)

  double timeStep() const { return frame / budget.substeps; }  // s, fixed
};

/// @throws std::invalid_argument naming the parameter, its value and its range
void validate(const ClayConfig& config);

/// Maximum number of samples that `Clay::advance` takes: one per spacing^2 on 1 m^2 of skin, but at least
/// 20 000 and at most 250 000. The skin of two hands has a tenth of this area. The maximum bounds the time
/// and the memory of a step.
/// @param spacing m, of the clay
std::size_t maxSkinSamples(double spacing);

/// A particle at the start.
struct InitialParticle {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f velocity;  // m/s
  std::uint8_t material = 0;
  std::uint16_t body = 0;
};

/// A lump with fewer particles than this is a crumb. Crumbs never sleep.
constexpr std::size_t crumb_size = 32;

struct Stage {
  std::string name;
  double ms = 0.0;  // of the last frame
};

struct Statistics {
  std::uint64_t step = 0;  // frames since the start
  std::size_t awake = 0;   // particles
  std::size_t bonds = 0;
  std::size_t contacts = 0;  // with samples and solids, in the last step
  double iterations = 0.0;   // per step, mean over the last frame
  double rounds = 0.0;       // per step, mean; contacts are updated between rounds
  std::size_t lumps = 0;     // connected components, awake or asleep
  std::size_t crumbs = 0;    // lumps of fewer than `crumb_size` particles
  std::size_t strays = 0;    // particles that left the scene and lie at the walls of the world
  // Displacements since the start that are not finite, or longer than the world is wide.
  std::uint64_t rejected_displacements = 0;
  std::uint64_t samples_looked_at = 0;  // in the last frame, by searches for a place that is free of hands
  double density_error_mean = 0.0;      // of max(rho / rho0 - 1, 0)
  double density_error_max = 0.0;
  std::vector<Stage> stages;
};

/// The clay: the paper's Algorithm 1 with its five constraint families (density, viscosity, elastoplastic
/// bonds, impenetrability, friction), solved together. The paper projects one constraint after the other.
/// Here a step minimises the incremental potential of all, m/(2 dt^2) |u - u_free|^2 + energies of the
/// constraints, by conjugate gradients with the contacts as prescribed directions. So a block at rest stays
/// at rest, and the contact force is its weight, however few iterations are spent; see doc/method/clay.md.
///
/// The same calls give the same bits, for any number of threads.
class Clay {
 public:
  /// @throws std::invalid_argument naming the parameter, its value and its range
  Clay(const ClayConfig& config, std::vector<Material> materials, std::vector<InitialParticle> particles);
  ~Clay();

  /// Advances by `duration` s. The number of time steps is rounded; the rest of the duration is carried into
  /// the next call. During the steps the samples move in straight lines to their positions. In each step a
  /// solid moves from its pose at the start of the step to its pose at the end; its velocity follows from
  /// these poses.
  /// @param solids their shapes; poses and velocities are not read
  /// @param motion their poses by simulated time; it is called with times from `time()` on
  /// @throws std::invalid_argument if there are more than `maxSkinSamples`, or not as many normals and
  /// velocities; the clay stays as it was
  void advance(const Skin& skin, const std::vector<Solid>& solids, const SolidMotion& motion,
               double duration);
  /// The same, with solids that start at their poses and move with their velocities.
  void advance(const Skin& skin, const std::vector<Solid>& solids, double duration);

  /// The present state of the clay.
  Sculpture sculpture() const;
  /// Continues from a sculpture of the same scene: the same particles, materials and spacing.
  /// @throws std::invalid_argument naming the difference; the clay stays as it was
  void restore(const Sculpture& sculpture);

  const ClayConfig& config() const;
  const std::vector<Material>& materials() const;
  const Particles& particles() const;
  double time() const;  // s, simulated

  /// Mean force on each touched sample over the last `advance`, by ascending sample.
  const std::vector<SkinForce>& skinForces() const;
  /// Mean force on each solid over the last `advance`, N.
  const std::vector<Eigen::Vector3d>& solidForces() const;
  const Statistics& statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile_clay::clay
