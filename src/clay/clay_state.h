#pragma once

#include <atomic>
#include <vector>

#include "clay/clay.h"
#include "clay/contact/contacts.h"
#include "clay/forces/bonds.h"
#include "clay/kernel.h"
#include "clay/neighbourhood.h"
#include "clay/paper/projection.h"
#include "clay/range_sums.h"
#include "clay/sleep.h"
#include "clay/solver/minimiser.h"
#include "clay/thread_team.h"

namespace tactile_clay::clay {

/// The whole state of the clay, and the course of a time step: neighbours, contacts, bonds, the solver, and
/// the new positions. Sleeping particles are only in `everyone`; their bonds and contacts are stored
/// separately.
struct Clay::State {
  enum StageIndex { neighbours, contact_search, bonds, setup, iterations, finish };

  State(const ClayConfig& config_in, std::vector<Material> materials_in,
        const std::vector<InitialParticle>& initial);

  double& ms(StageIndex stage) { return statistics.stages[stage].ms; }
  bool sleeps() const { return config.sleeping && config.budget.method != Method::paper; }

  // Inputs and results of a frame: clay_state.cpp.
  void takeParticles(const std::vector<InitialParticle>& initial);
  void setWalls();
  void takeSamples(const Skin& skin);
  void moveSamples(float remaining);
  Surroundings withWalls(const Surroundings& around, double farthest);
  void posesAt(const SolidMotion& motion, double t, std::size_t solids);
  Surroundings surroundings(const std::vector<Solid>& solids) const;
  void beginFrame(const Skin& skin, std::size_t solids, int steps);
  void endFrame(int steps);
  void countLumps();
  void countStrays();
  // A step: clay_step.cpp.
  void step(const Surroundings& around);
  void updateBonds(bool form);
  void endStep(float dt);
  void collectForces(int steps, float dt);
  // Sculptures, and the separation of awake and sleeping particles: clay_sculpture.cpp.
  void publishAwake();
  Sculpture sculpture() const;
  void restore(const Sculpture& sculpture);
  void regroup();

  ClayConfig config;
  std::vector<Material> materials;
  ThreadTeam team;
  Particles everyone;                // all particles, awake or asleep, as others see them
  std::vector<std::uint32_t> awake;  // indices of awake particles, ascending
  Particles particles;               // awake particles; the members below belong to them
  VectorField free;                  // m, displacements without internal and contact forces
  VectorField u;                     // m, displacements of the step
  RangeSums range_sums;
  Kernel kernel;
  Neighbourhood near;
  Minimiser minimiser;
  Projection projection;
  Bonds bond_constraint;
  Contacts contact_constraint;
  Sleep sleep;
  // Bonds and contacts of sleeping particles, with indices into `everyone`. The bonds of particle i are those
  // from begin[i] to begin[i + 1]. The contacts press on the solids with their last forces.
  std::vector<std::uint32_t> sleeping_bond_begin;
  std::vector<Bond> sleeping_bonds;
  std::vector<Contact> sleeping_contacts;
  bool bonded = false;
  VectorField window_start;                  // m, positions at the last step that could form bonds
  int window_steps = 0;                      // steps since then
  bool fresh = true;                         // whether the particles are not those of the last step
  int iterations_done = 0, rounds_done = 0;  // in this frame
  std::atomic<std::uint64_t> rejected{0};    // displacements, since the start
  double time = 0.0, carry = 0.0;            // s
  Skin target;                               // samples at the end of the frame
  Skin moved;                                // samples at the end of the current step
  std::vector<Solid> walls;                  // of the world
  std::vector<Solid> walled;                 // solids of the step and walls, with their poses below
  std::vector<Eigen::Isometry3d> walled_start, walled_end;
  std::vector<Eigen::Isometry3d> start_poses, end_poses;  // of the solids, of the step
  struct SampleSum {                                      // sums over the steps of the frame
    Eigen::Vector3d force = Eigen::Vector3d::Zero();      // N
    double pressed = 0.0, slip = 0.0;                     // N, magnitudes; N m/s, magnitudes times slip
    bool touched = false;
  };
  std::vector<SampleSum> sample_sums;
  std::vector<SkinForce> skin_forces;
  std::vector<Eigen::Vector3d> solid_forces;
  Statistics statistics;
};

}  // namespace tactile_clay::clay
