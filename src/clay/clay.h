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

/// How much is spent on a frame, and on which method. What it buys stands in doc/method/speed_accuracy.md.
struct Budget {
  int substeps = 4;    // of a frame
  int iterations = 8;  // of all constraints together, in a substep
  Method method = Method::minimise;
};

struct ClayConfig {
  double spacing = 0.005;     // m, between particles of the initial lattice
  double frame = 1.0 / 60.0;  // s
  Budget budget;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  // m/s^2
  double world = 1.0;                        // m, half extent of the cube that particles cannot leave
  double tolerance = 0.01;  // m/s^2, iterations stop where no particle lacks more acceleration than this
  int threads = 0;          // 0: as many as there are cores
  bool sleeping = true;     // leave clay at rest alone until something comes near (class Sleep)

  double timeStep() const { return frame / budget.substeps; }  // s, fixed
};

/// @throws std::invalid_argument naming the parameter, its value and its range
void validate(const ClayConfig& config);

/// Samples that `Clay::advance` takes at most: as many as fill 1 m^2 of skin, of which two hands have a
/// tenth, and not so many that a step, or its memory, has no bound.
/// @param spacing m, of the clay
std::size_t maxSkinSamples(double spacing);

/// Particles to start from.
struct InitialParticle {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f velocity;  // m/s
  std::uint8_t material = 0;
  std::uint16_t body = 0;
};

/// Particles; lumps of fewer are crumbs, which never sleep.
constexpr std::size_t crumb_size = 32;

struct Stage {
  std::string name;
  double ms = 0.0;  // of the last frame
};

struct Statistics {
  std::uint64_t step = 0;  // frames since the start
  std::size_t awake = 0;   // particles
  std::size_t bonds = 0;
  std::size_t contacts = 0;  // with samples and solids, last substep
  double iterations = 0.0;   // of a substep, mean over the last frame
  double rounds = 0.0;       // of a substep, mean; between them contacts are looked at anew
  std::size_t lumps = 0;     // connected components, awake or asleep
  std::size_t crumbs = 0;    // lumps of fewer than `crumb_size` particles
  std::size_t strays = 0;    // particles that left the scene: they lie at the walls of the world
  std::uint64_t rejected_displacements = 0;  // since the start; not finite, or longer than the world is wide
  std::uint64_t samples_looked_at = 0;  // in the last frame, by searches for a place that is free of hands
  double density_error_mean = 0.0;      // of max(rho / rho0 - 1, 0)
  double density_error_max = 0.0;
  std::vector<Stage> stages;
};

/// The clay: the paper's Algorithm 1 with its five constraint families (density, viscosity, elastoplastic
/// bonds, impenetrability, friction), solved together. Where the paper projects constraint after constraint,
/// a step here minimises their incremental potential, m/(2 dt^2) |u - u_free|^2 + energies of the
/// constraints, by conjugate gradients with the contacts as prescribed directions. A block at rest then stays
/// at rest, and the contact force stays its weight, however few iterations are spent; see doc/method/clay.md.
///
/// The same calls give the same bits, for any number of threads.
class Clay {
 public:
  /// @throws std::invalid_argument naming the parameter, its value and its range
  Clay(const ClayConfig& config, std::vector<Material> materials, std::vector<InitialParticle> particles);
  ~Clay();

  /// Advances by `duration` s in whole time steps, rounded; what remains is carried into the next call. Over
  /// the steps samples move straight to their positions. In each step a solid goes from its pose at the start
  /// of the step to its pose at the end; its velocity is what takes it there.
  /// @param solids their shapes; poses and velocities are not read
  /// @param motion their poses, by `time()`; it is asked for times from `time()` on
  /// @throws std::invalid_argument where there are more than `maxSkinSamples`, and the clay stays as it was
  void advance(const Skin& skin, const std::vector<Solid>& solids, const SolidMotion& motion,
               double duration);
  /// The same with solids that move from their poses with their velocities.
  void advance(const Skin& skin, const std::vector<Solid>& solids, double duration);

  /// What the clay is now.
  Sculpture sculpture() const;
  /// Goes on from a sculpture of the same scene: the same particles, materials and spacing.
  /// @throws std::invalid_argument naming what differs, and the clay stays as it was
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
