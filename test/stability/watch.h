#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "clay/kernel.h"
#include "clay/lattice.h"
#include "clay/neighbourhood.h"
#include "support/setups.h"

/// The requirements in every extreme: nothing becomes NaN, no particle leaves the world, and no energy comes
/// from nowhere.
namespace tactile_clay::clay {

/// A simulation to be watched.
struct Trial {
  ClayConfig config;
  std::vector<Material> materials{Material()};
  std::vector<InitialParticle> particles;
  int frames = 60;
  std::function<Skin(double)> samples = [](double) { return Skin(); };  // at a time, s
  std::function<std::vector<Solid>(double)> solids = [](double) { return std::vector<Solid>{ground()}; };
  double collider_speed = 0.0;  // m/s, of the fastest point of a moving collider
  bool squeezes = false;        // moving colliders press clay that cannot evade
  bool energy = true;           // whether energy is watched
  double overlap = 0.0;         // m, by which the clay starts inside a collider
};

/// Energy of compression that the particles start with: sum of kappa/2 V max(rho/rho_0 - 1, 0)^2, J.
inline double storedEnergy(const Trial& trial) {
  const Kernel kernel(static_cast<float>(2.0 * trial.config.spacing));
  VectorField x;
  x.resize(trial.particles.size());
  for (std::size_t i = 0; i < x.size(); ++i) x.set(i, trial.particles[i].position);
  Neighbourhood near(kernel.h);
  near.build(x);
  const double rest = latticeSum(kernel, static_cast<float>(trial.config.spacing));
  double energy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    double total = kernel.sigma;
    for (std::uint32_t p = near.begin(i); p < near.end(i); ++p) total += kernel.value(near.offset(p).norm());
    const double compression = std::max(total / rest - 1.0, 0.0);
    energy += 0.5 * trial.materials[trial.particles[i].material].bulk_modulus *
              std::pow(trial.config.spacing, 3.0) * compression * compression;
  }
  return energy;
}

/// Runs a trial. The kinetic energy may not exceed the sum of
/// - the kinetic energy at the start,
/// - the work of gravity, M g . (x - x_0) of the centre of mass,
/// - the energy stored by compression at the start,
/// - the work of moving colliders: elastic clay that is struck at V leaves with at most 2 V, M (2 V)^2 / 2;
///   if clay is squeezed, the work of the forces on the samples, if that is larger,
/// - the energy for undoing a start inside a collider: lifting by the overlap, and 0.5 m/s of recovery,
/// - slack: 1 % of all that, and 20 mm/s of every particle, which is what the step of a contact that was met
///   late can give.
inline void watch(Trial trial) {
  trial.config.sleeping = false;  // what is asleep cannot fail
  Clay clay(trial.config, trial.materials, trial.particles);
  const Particles& p = clay.particles();
  const double world = static_cast<float>(trial.config.world);
  const double total = totalMass(p), first = kineticEnergy(p), stored = storedEnergy(trial);
  const Eigen::Vector3d start = p.size() > 0 ? centreOfMass(p) : Eigen::Vector3d::Zero();
  const double pull = trial.config.gravity.norm();
  const double struck = 0.5 * total * std::pow(2.0 * trial.collider_speed, 2.0);
  const double undone = trial.overlap > 0.0 ? total * (pull * trial.overlap + 0.5 * 0.25) : 0.0;
  double squeezed = 0.0, worst = 0.0, allowed_then = 0.0;
  int worst_frame = -1;
  for (int k = 1; k <= trial.frames; ++k) {
    const double before = clay.time();
    const Skin samples = trial.samples(before + trial.config.frame);
    clay.advance(samples, trial.solids(before), trial.config.frame);
    for (std::size_t i = 0; i < p.size(); ++i) {
      ASSERT_TRUE(p.position.at(i).allFinite() && p.velocity.at(i).allFinite())
          << "particle " << i << " frame " << k;
      ASSERT_LE(p.position.at(i).cwiseAbs().maxCoeff(), world) << "particle " << i << " frame " << k;
    }
    for (const SkinForce& f : clay.skinForces()) {
      ASSERT_TRUE(f.force.allFinite()) << "frame " << k;
      if (trial.squeezes) squeezed -= f.force.dot(samples.velocity[f.index]) * trial.config.frame;
    }
    for (const Eigen::Vector3d& f : clay.solidForces()) ASSERT_TRUE(f.allFinite()) << "frame " << k;
    if (p.size() == 0) continue;
    const double fallen = total * trial.config.gravity.dot(centreOfMass(p) - start);
    const double allowed =
        1.01 * (first + std::max(fallen, 0.0) + stored + std::max(struck, squeezed) + undone) +
        std::min(fallen, 0.0) + 0.5 * total * 0.02 * 0.02;
    const double excess = kineticEnergy(p) - allowed;
    if (excess > worst) {
      worst = excess;
      worst_frame = k;
      allowed_then = allowed;
    }
  }
  if (!trial.energy) return;
  EXPECT_LE(worst, 0.0) << "J of kinetic energy too much at frame " << worst_frame << " of " << trial.frames
                        << ", allowed " << allowed_then << " J, mean speed " << meanSpeed(p)
                        << " m/s at the end";
}

}  // namespace tactile_clay::clay
