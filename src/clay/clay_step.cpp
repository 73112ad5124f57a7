#include <algorithm>
#include <cmath>

#include "clay/clay_state.h"
#include "clay/stopwatch.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
void Clay::State::step(const Surroundings& around) {
  const float dt = around.dt;
  const Eigen::Vector3f gravity = config.gravity.cast<float>();
  const Sums ways = range_sums.of(particles.size(), [&](std::size_t first, std::size_t last) {
    Sums sums;
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector3f x = particles.position.at(i),
                            way = dt * (particles.velocity.at(i) + dt * gravity);
      free.set(i, way);
      sums.largest = std::max({sums.largest, x.cwiseAbs().maxCoeff(), (x + way).cwiseAbs().maxCoeff()});
    }
    return sums;
  });
  const Surroundings walled_in = withWalls(around, ways.largest);
  {
    const Stopwatch watch(ms(neighbours));
    near.build(particles.position);
  }
  {
    const Stopwatch watch(ms(contact_search));
    contact_constraint.detect(near, particles, free, walled_in);
  }
  const bool begins = window_steps >= config.budget.substeps;
  window_steps = begins ? 1 : window_steps + 1;
  if (bonded) {
    const Stopwatch watch(ms(bonds));
    updateBonds(begins);
  }
  const StepInput input{near, particles, bonded ? &bond_constraint : nullptr, free, dt, fresh || begins};
  fresh = false;
  if (config.budget.method == Method::paper) {
    const Stopwatch watch(ms(iterations));
    contact_constraint.restore(
        projection.solve(input, config.budget.iterations, contact_constraint.contacts(), u));
  } else {
    const Minimiser::Goal goal{gravity, config.budget.iterations, config.tolerance};
    double whole_ms = 0.0;
    Minimiser::Solved solved;
    {
      const Stopwatch watch(whole_ms);
      solved = minimiser.solve(input, contact_constraint, goal, u);
    }
    ms(setup) += solved.setup_ms;
    ms(iterations) += whole_ms - solved.setup_ms;
    iterations_done += solved.iterations;
    rounds_done += solved.rounds;
    statistics.samples_looked_at += contact_constraint.looks();
  }
  endStep(dt);
}

/// Bonds form and break by how far a pair has moved apart in a frame, not by the velocities of a step. These
/// carry the noise of the solver, and a threshold that is checked more often is crossed more often. A bond
/// breaks as soon as its frame is certain to be too fast. Bonds form only at the end of a frame.
/// @param form whether they form now
void Clay::State::updateBonds(bool form) {
  const float per_frame = static_cast<float>(1.0 / config.frame);
  VectorField& mean_velocity = u;  // u is not in use before the step is solved
  parallelRanges(particles.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      mean_velocity[i] = per_frame * (particles.position[i] - window_start[i]);
      if (form) window_start[i] = particles.position[i];
    }
  });
  bond_constraint.update(near, particles, mean_velocity, form, static_cast<float>(config.timeStep()),
                         contact_constraint.contacts());
}

void Clay::State::endStep(float dt) {
  const Stopwatch watch(ms(finish));
  const float world = static_cast<float>(config.world);
  const bool minimised = config.budget.method != Method::paper;
  const VectorField* const recovery = minimised ? minimiser.recovery() : nullptr;
  parallelRanges(particles.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      // A particle is lost if its displacement is not finite, or longer than the world is wide. It stops
      // where it is.
      Eigen::Vector3f step = u.at(i);
      if (!(step.norm() < 2.0f * world)) {
        step.setZero();
        ++rejected;
      }
      Eigen::Vector3f next = particles.position.at(i) + step;
      if (recovery != nullptr) {
        if (recovery->at(i).norm() < world)
          next += recovery->at(i);
        else
          ++rejected;
      }
      const Eigen::Vector3f inside = next.cwiseMax(-world).cwiseMin(world);
      particles.position.set(i, inside);
      particles.velocity.set(i, (inside.array() == next.array()).select(step / dt, 0.0f));
      if (minimised) particles.compression[i] = minimiser.compression(near, i);
    }
  });
}

/// Adds the contact forces of the last step, and their slip, to the means of the frame. A contact that sticks
/// to its anchor has no slip. An anchor that is dragged along moves with its particle.
void Clay::State::collectForces(int steps, float dt) {
  for (const Contact& c : sleeping_contacts)
    if (c.solid < solid_forces.size()) solid_forces[c.solid] -= c.force.cast<double>() / steps;
  for (const Contact& c : contact_constraint.contacts()) {
    const Eigen::Vector3d force = -c.force.cast<double>() / steps;
    if (c.solid != Contact::skin) {
      if (c.solid < solid_forces.size()) solid_forces[c.solid] += force;
      continue;
    }
    if (c.force.isZero(0.0f)) continue;
    const Eigen::Vector3f way = u.at(c.particle) - c.drift;
    const double size = force.norm();
    const bool slides = c.state == Contact::State::slide || !(c.stiffness > 0.0f);  // or has no friction
    double slip = slides ? c.along(way).norm() / dt : 0.0;
    if (!std::isfinite(slip)) slip = 0.0;  // the particle is lost in this step
    for (std::uint32_t s = c.first_sample; s < c.first_sample + c.sample_count; ++s) {
      const SampleShare& share = contact_constraint.shares()[s];
      SampleSum& sum = sample_sums[share.sample];
      sum.force += share.share * force;
      sum.pressed += share.share * size;
      sum.slip += share.share * size * slip;
      sum.touched = true;
    }
  }
}

}  // namespace tactile_clay::clay
