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

/// All that the clay is, and how a time step goes: neighbours, contacts, bonds, the solver, and the new
/// positions. What sleeps is in `everyone` alone, with its bonds and contacts set aside.
struct Clay::State {
  enum StageIndex { neighbours, contact_search, bonds, setup, iterations, finish };

  State(const ClayConfig& config_in, std::vector<Material> materials_in,
        const std::vector<InitialParticle>& initial);

  double& ms(StageIndex stage) { return statistics.stages[stage].ms; }
  bool sleeps() const { return config.sleeping && config.budget.method != Method::paper; }

  // What comes in, and what is told of a frame: clay_state.cpp.
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
  // What is kept, and what sleeps: clay_sculpture.cpp.
  void publishAwake();
  Sculpture sculpture() const;
  void restore(const Sculpture& sculpture);
  void regroup();

  ClayConfig config;
  std::vector<Material> materials;
  ThreadTeam team;
  Particles everyone;                // as the world sees them, also those that sleep
  std::vector<std::uint32_t> awake;  // which of them are awake, ascending
  Particles particles;               // those awake; everything below is of them
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
  // Of those that sleep, with indices into `everyone`: bonds, from begin[i] to begin[i + 1], and contacts,
  // which press the solids with what they last did.
  std::vector<std::uint32_t> sleeping_bond_begin;
  std::vector<Bond> sleeping_bonds;
  std::vector<Contact> sleeping_contacts;
  bool bonded = false;
  VectorField window_start;                  // m, positions when bonds were last decided on
  int window_steps = 0;                      // steps since
  int iterations_done = 0, rounds_done = 0;  // in this frame
  std::atomic<std::uint64_t> rejected{0};    // displacements, since the start
  double time = 0.0, carry = 0.0;            // s
  Skin target;                               // samples at the end of the frame
  Skin moved;                                // and at the end of the current step
  std::vector<Solid> walls;                  // of the world
  std::vector<Solid> walled;                 // solids of the step and walls, and their poses then
  std::vector<Eigen::Isometry3d> walled_start, walled_end;
  std::vector<Eigen::Isometry3d> start_poses, end_poses;  // of the solids, in the step
  struct SampleSum {                                      // over the steps of the frame
    Eigen::Vector3d force = Eigen::Vector3d::Zero();      // N
    double pressed = 0.0, slip = 0.0;                     // N, of magnitudes; N m/s, the same times slip
    bool touched = false;
  };
  std::vector<SampleSum> sample_sums;
  std::vector<SkinForce> skin_forces;
  std::vector<Eigen::Vector3d> solid_forces;
  Statistics statistics;
};

}  // namespace tactile_clay::clay
