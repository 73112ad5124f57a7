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

Minimiser::Minimiser(const Neighbourhood& near, const Particles& particles, const Kernel& kernel,
                     double spacing, const std::vector<Material>& materials)
    : near_(near),
      particles_(particles),
      lumps_(near, particles, spacing),
      potential_(kernel, static_cast<float>(spacing), materials),
      descent_(near, particles, lumps_) {}

Minimiser::Solved Minimiser::solve(const Bonds* bonds, const VectorField& free, Contacts& contacts, float dt,
                                   const Goal& goal, VectorField& u) {
  Solved solved;
  free_ = &free;
  contacts_ = &contacts;
  dt_ = dt;
  {
    const Stopwatch watch(solved.setup_ms);
    step_ = &potential_.linearise({near_, particles_, bonds, free, dt}, contacts.contacts());
    contacts.remember(potential_.boundaryShares());
    descent_.begin(*step_, free, contacts, dt);
    lumps_.measure();
  }
  start(goal.gravity, u);            // from the last velocity
  solved.rounds = iterate(goal, u);  // lumps as a whole, then conjugate gradients, then contacts anew
  makeRoom(u);                       // what is still inside of colliders goes out
  shorten(u);                        // where it went farther than any energy took it
  balanceForces(u);                  // contacts bear all of the momentum
  keepCompression();                 // no more than what was paid for
  contacts.finish(particles_, dt);   // anchors slide
  undoExcess(u);                     // of compression, by displacements that are no motion
  solved.iterations = descent_.iterations();
  return solved;
}

/// Starts from the last velocity: what rests starts at rest, however few iterations follow. What falls or
/// slides is set going by `translate`.
void Minimiser::start(const Eigen::Vector3f& gravity, VectorField& u) {
  const Eigen::Vector3f fall = dt_ * dt_ * gravity;
  const std::vector<Eigen::Matrix3f> bend = lumps_.bends(dt_);
  parallelFor(particles_.size(), range_size, [&](std::size_t i) {
    const Eigen::Vector3f arm = particles_.position.at(i) - lumps_.centreAt(i).cast<float>();
    u.set(i, free_->at(i) - fall + bend[near_.lump(i)] * arm);
  });
}

/// Rounds of iterations; between them contacts and compression are looked at anew. \return how many
int Minimiser::iterate(const Goal& goal, VectorField& u) {
  int rounds = 0, rounds_more = max_rounds_more, left = goal.iterations;
  while (left > 0) {
    ++rounds;
    translate(u);
    // Friction as it was in the last step foretells the slip, in the first of several rounds.
    if (left < goal.iterations || left <= iterations_a_round) contacts_->dampSlides(particles_, u, dt_);
    const bool solved = descent_.descend(std::min(left, iterations_a_round), goal.tolerance, u);
    const Contacts::Changes changes = contacts_->update(particles_, u, descent_.residual());
    const bool strayed = contacts_->detectStrays(particles_, u, dt_);
    if (solved && !changes.any && !strayed) break;
    const bool last = left <= iterations_a_round;
    if (last && rounds_more > 0 && gainsByPull(changes.pulled, goal.gravity, u))
      --rounds_more;
    else
      left -= iterations_a_round;
  }
  return rounds;
}

/// Moves each lump as a whole, but through nothing: what it meets stops it there, and it goes on in the
/// directions that are left, of which there are three.
void Minimiser::translate(VectorField& u) {
  bool met = true;
  for (int k = 0; k < directions && met; ++k) {
    contacts_->prescribe(u);
    std::vector<Eigen::Vector3f> falls = lumps_.falls(*free_, u, *contacts_, dt_);
    const std::vector<std::uint32_t> closing = lumps_.meet(u, *contacts_, falls);
    contacts_->close(closing);
    met = !closing.empty();
    parallelFor(particles_.size(), range_size, [&](std::size_t i) { u.add(i, falls[near_.lump(i)]); });
  }
  contacts_->prescribe(u);
}

/// What the iterations left inside of colliders goes out, whatever it takes. Out of one side of the skin may
/// be into another.
void Minimiser::makeRoom(VectorField& u) {
  contacts_->expel(particles_, u, dt_);
  for (int k = 0; k < max_sides && contacts_->detectStrays(particles_, u, dt_); ++k)
    contacts_->expel(particles_, u, dt_);
  contacts_->release(particles_, u, dt_);
}

/// Contacts together give a lump the momentum that it gained. What few iterations leave unsolved, forces that
/// nobody exerts, is made up by the contacts of the lump, each by its share, so that the sum of Eq. 6 is the
/// rate of momentum for any budget.
void Minimiser::balanceForces(const VectorField& u) {
  const std::vector<float>& inertia = descent_.inertia();
  const auto& inertial = inertial_forces_.of(near_, particles_.size(), [&](std::size_t i) {
    const LumpSums<3>::Sum sum = (inertia[i] * (u.at(i) - free_->at(i))).cast<double>();
    return sum;
  });
  contacts_->balance(near_, {inertial.begin(), inertial.end()});
}

/// Undoes some of the compression that nothing did work for, by displacements beside u.
void Minimiser::undoExcess(const VectorField& u) {
  if (!step_->excessive) return;
  recovery_.resize(particles_.size());
  step_->recover(descent_.compression(), recovery_);
  contacts_->stop(particles_, u, recovery_);
}

}  // namespace tactile_clay::clay
