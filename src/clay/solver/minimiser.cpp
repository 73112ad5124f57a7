#include "clay/solver/minimiser.h"

#include <algorithm>

#include "clay/stopwatch.h"

namespace tactile_clay::clay {
namespace {

// Fewer would leave nothing to be conjugate to, more would solve with contacts that are wrong by then.
constexpr int iterations_a_round = 4;
// Rounds beyond the budget, at most, where contacts pulled: they bound the cost of a step.
constexpr int max_rounds_more = 8;
// Times that what was pushed out of one side of the skin may be pushed out of another; then it is released.
constexpr int max_sides = 8;
// Directions in which a lump can be stopped.
constexpr int directions = 3;

}  // namespace

Minimiser::Minimiser(const Kernel& kernel, double spacing, const std::vector<Material>& materials)
    : lumps_(spacing), potential_(kernel, static_cast<float>(spacing), materials) {}

Minimiser::Solved Minimiser::solve(const StepInput& in, Contacts& contacts, const Goal& goal,
                                   VectorField& u) {
  Solved solved;
  const Step step{in, contacts, goal};
  {
    const Stopwatch watch(solved.setup_ms);
    potential_.linearise(in, contacts.contacts(), step_);
    contacts.remember(potential_.boundaryShares());
    descent_.begin(in);
    lumps_.measure(in);
  }
  start(step, u);                        // from the last velocity
  solved.rounds = iterate(step, u);      // lumps as a whole, then conjugate gradients, then contacts anew
  makeRoom(step, u);                     // what is still inside of colliders goes out
  shorten(step, u);                      // where it went farther than any energy took it
  balanceForces(step, u);                // contacts bear all of the momentum
  keepCompression(step);                 // no more than what was paid for
  contacts.finish(in.particles, in.dt);  // anchors slide
  undoExcess(step, u);                   // of compression, by displacements that are no motion
  solved.iterations = descent_.iterations();
  return solved;
}

/// Starts from the last velocity: what rests starts at rest, however few iterations follow. What falls or
/// slides is set going by `translate`.
void Minimiser::start(const Step& step, VectorField& u) {
  const StepInput& in = step.in;
  const Eigen::Vector3f fall = in.dt * in.dt * step.goal.gravity;
  const std::vector<Eigen::Matrix3f> bend = lumps_.bends(in);
  parallelFor(in.particles.size(), range_size, [&](std::size_t i) {
    const Eigen::Vector3f arm = in.particles.position.at(i) - lumps_.centreAt(in, i).cast<float>();
    u.set(i, in.free.at(i) - fall + bend[in.near.lump(i)] * arm);
  });
}

/// Rounds of iterations; between them contacts and compression are looked at anew.
/// @return how many
int Minimiser::iterate(const Step& step, VectorField& u) {
  const auto& [in, contacts, goal] = step;
  int rounds = 0, rounds_more = max_rounds_more, left = goal.iterations;
  while (left > 0) {
    ++rounds;
    translate(step, u);
    // Friction as it was in the last step foretells the slip, in the first of several rounds.
    if (left < goal.iterations || left <= iterations_a_round) contacts.dampSlides(in.particles, u, in.dt);
    const bool solved =
        descent_.descend(descentOf(step), std::min(left, iterations_a_round), goal.tolerance, lumps_, u);
    const Contacts::Changes changes = contacts.update(in.particles, u, descent_.residual());
    const bool strayed = contacts.detectStrays(in.particles, u, in.dt);
    if (solved && !changes.any && !strayed) break;
    const bool last = left <= iterations_a_round;
    if (last && rounds_more > 0 && gainsByPull(step, changes.pulled, u))
      --rounds_more;
    else
      left -= iterations_a_round;
  }
  return rounds;
}

/// Moves each lump as a whole, but through nothing: what it meets stops it there, and it goes on in the
/// directions that are left, of which there are three.
void Minimiser::translate(const Step& step, VectorField& u) {
  const StepInput& in = step.in;
  bool met = true;
  for (int k = 0; k < directions && met; ++k) {
    step.contacts.prescribe(u);
    std::vector<Eigen::Vector3f> falls = lumps_.falls(in, u, step.contacts);
    const std::vector<std::uint32_t> closing = lumps_.meet(in, u, step.contacts, falls);
    step.contacts.close(closing);
    met = !closing.empty();
    parallelFor(in.particles.size(), range_size, [&](std::size_t i) { u.add(i, falls[in.near.lump(i)]); });
  }
  step.contacts.prescribe(u);
}

/// What the iterations left inside of colliders goes out, whatever it takes. Out of one side of the skin may
/// be into another.
void Minimiser::makeRoom(const Step& step, VectorField& u) {
  const Particles& particles = step.in.particles;
  const float dt = step.in.dt;
  step.contacts.expel(particles, u, dt);
  for (int k = 0; k < max_sides && step.contacts.detectStrays(particles, u, dt); ++k)
    step.contacts.expel(particles, u, dt);
  step.contacts.release(particles, u, dt);
}

/// Contacts together give a lump the momentum that it gained. What few iterations leave unsolved, forces that
/// nobody exerts, is made up by the contacts of the lump, each by its share, so that the sum of Eq. 6 is the
/// rate of momentum for any budget.
void Minimiser::balanceForces(const Step& step, const VectorField& u) {
  const StepInput& in = step.in;
  const std::vector<float>& inertia = descent_.inertia();
  const auto inertial = inertial_forces_.of(in.near, in.particles.size(), [&](std::size_t i) {
    const Eigen::Vector3d force = (inertia[i] * (u.at(i) - in.free.at(i))).cast<double>();
    return force;
  });
  step.contacts.balance(in.near, {inertial.begin(), inertial.end()});
}

/// Undoes some of the compression that nothing did work for, by displacements beside u.
void Minimiser::undoExcess(const Step& step, const VectorField& u) {
  if (!step_.excessive) return;
  recovery_.resize(step.in.particles.size());
  step_.recover(descent_.compression(), recovery_);
  step.contacts.stop(step.in.particles, u, recovery_);
}

}  // namespace tactile_clay::clay
