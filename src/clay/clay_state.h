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

/// The whole state of the clay, and its time step: neighbours, contacts, bonds, the solver, and the new
/// positions. Particles that sleep are in `everyone` alone. Their bonds and contacts are set aside.
struct Clay::State {
  enum StageIndex { neighbours, contact_search, bonds, setup, iterations, finish };

  State(const ClayConfig& config_in, std::vector<Material> materials_in,
        const std::vector<InitialParticle>& initial);

  double& ms(StageIndex stage) { return statistics.stages[stage].ms; }
  bool sleeps() const { return config.sleeping && config.budget.method != Method::paper; }

  // Input, and the results of a frame: clay_state.cpp.
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
  void updateBonds();
  void endStep(float dt);
  void collectForces(int steps, float dt);
  // Sculptures, and clay that sleeps: clay_sculpture.cpp.
  void publishAwake();
  Sculpture sculpture() const;
  void restore(const Sculpture& sculpture);
  void regroup();

  ClayConfig config;
  std::vector<Material> materials;
  ThreadTeam team;
  Particles everyone;                // all particles, awake or asleep, as callers see them
  std::vector<std::uint32_t> awake;  // indices in `everyone` of those that are awake, ascending
  Particles particles;               // those that are awake; a step works on these alone
  VectorField free;                  // m, displacements of the step without internal and contact forces
  VectorField u;                     // m, displacements of the step
  RangeSums range_sums;
  Kernel kernel;
  Neighbourhood near;
  Minimiser minimiser;
  Projection projection;
  Bonds bond_constraint;
  Contacts contact_constraint;
  Sleep sleep;
  // Of the particles that sleep, with indices into `everyone`: bonds of particle i, from begin[i] to
  // begin[i + 1], and contacts, which go on pressing the solids with their last forces.
  std::vector<std::uint32_t> sleeping_bond_begin;
  std::vector<Bond> sleeping_bonds;
  std::vector<Contact> sleeping_contacts;
  bool bonded = false;
  VectorField window_start;                  // m, positions at the last update that may form bonds
  int window_steps = 0;                      // steps since then
  int iterations_done = 0, rounds_done = 0;  // in this frame
  std::atomic<std::uint64_t> rejected{0};    // number of displacements, since the start
  double time = 0.0, carry = 0.0;            // s
  Skin target;                               // the samples at the end of the frame
  Skin moved;                                // the samples at the end of the current step
  std::vector<Solid> walls;                  // walls of the world
  std::vector<Solid> walled;                 // solids and walls; below, their poses in the step
  std::vector<Eigen::Isometry3d> walled_start, walled_end;
  std::vector<Eigen::Isometry3d> start_poses, end_poses;  // of the solids, at both ends of the step
  struct SampleSum {                                      // sums of a sample over the steps of the frame
    Eigen::Vector3d force = Eigen::Vector3d::Zero();      // N
    double pressed = 0.0, slip = 0.0;  // N, sum of magnitudes; N m/s, sum of magnitude times slip
    bool touched = false;
  };
  std::vector<SampleSum> sample_sums;
  std::vector<SkinForce> skin_forces;
  std::vector<Eigen::Vector3d> solid_forces;
  Statistics statistics;
};

}  // namespace tactile_clay::clay
