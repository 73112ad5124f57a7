#include "clay/solver/minimiser.h"

#include <algorithm>

#include "clay/stopwatch.h"

namespace tactile_clay::clay {
namespace {

// Fewer iterations would leave no directions to be conjugate to. With more, contacts would be out of date.
constexpr int iterations_a_round = 4;
// Maximum number of rounds beyond the budget if contacts pulled. It bounds the cost of a step.
constexpr int max_rounds_more = 8;
// How often clay that was pushed out of one side of the skin may be pushed out of another before `release`.
constexpr int max_sides = 8;
// Directions in which a lump can be stopped.
constexpr int directions = 3;

}  // namespace

Minimiser::Minimiser(const Kernel& kernel, double spacing, const std::vector<Material>& materials)
    : lumps_(spacing),
      potential_(kernel, static_cast<float>(spacing), materials),
      descent_(static_cast<float>(spacing)) {}

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
  solved.rounds = iterate(step, u);      // whole lumps, conjugate gradients, new states of contacts
  makeRoom(step, u);                     // pushes out particles that are still inside of colliders
  shorten(step, u);                      // if lumps may have gained energy
  balanceForces(step, u);                // contact forces add up to the change of momentum without gravity
  keepCompression(step);                 // only the part that was paid for
  contacts.finish(in.particles, in.dt);  // anchors slide
  undoExcess(step, u);                   // undoes compression without adding velocity
  solved.iterations = descent_.iterations();
  return solved;
}

/// Starts from the last velocity, without gravity. So clay at rest starts at rest, however few iterations
/// follow. `translate` sets lumps in motion that fall or slide.
void Minimiser::start(const Step& step, VectorField& u) {
  const StepInput& in = step.in;
  const Eigen::Vector3f fall = in.dt * in.dt * step.goal.gravity;
  const std::vector<Eigen::Matrix3f> bend = lumps_.bends(in);
  parallelFor(in.particles.size(), range_size, [&](std::size_t i) {
    const Eigen::Vector3f arm = in.particles.position.at(i) - lumps_.centreAt(in, i).cast<float>();
    u.set(i, in.free.at(i) - fall + bend[in.near.lump(i)] * arm);
  });
}

/// Runs rounds of iterations. Contacts and compression are updated between them, yield after the first one.
/// @return number of rounds
int Minimiser::iterate(const Step& step, VectorField& u) {
  const auto& [in, contacts, goal] = step;
  int rounds = 0, rounds_more = max_rounds_more, left = goal.iterations;
  while (left > 0) {
    if (++rounds == 2) potential_.yieldAt(u, in, contacts.contacts(), step_);
    translate(step, u);
    // The first of several rounds predicts the slip with the friction of the last step. In all other rounds,
    // slides are damped.
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

/// Moves each lump as a whole, but not through colliders. A collider that it meets stops it there. The lump
/// then goes on in the directions that are left; there are three directions in all.
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

/// Pushes out the particles that the iterations left inside of colliders, whatever force that takes. A
/// particle that leaves one side of the skin may get into another side.
void Minimiser::makeRoom(const Step& step, VectorField& u) {
  const Particles& particles = step.in.particles;
  const float dt = step.in.dt;
  step.contacts.expel(particles, u, dt);
  for (int k = 0; k < max_sides && step.contacts.detectStrays(particles, u, dt); ++k)
    step.contacts.expel(particles, u, dt);
  step.contacts.release(particles, u, dt);
}

/// Makes the contact forces on each lump add up to its change of momentum without gravity. Few iterations
/// leave a residual, a force that nothing exerts. The contacts of the lump take it over, each by its share.
/// So the sum of Eq. 6 is the rate of momentum for any budget.
void Minimiser::balanceForces(const Step& step, const VectorField& u) {
  const StepInput& in = step.in;
  const std::vector<float>& inertia = descent_.inertia();
  const auto inertial = inertial_forces_.of(in.near, in.particles.size(), [&](std::size_t i) {
    const Eigen::Vector3d force = (inertia[i] * (u.at(i) - in.free.at(i))).cast<double>();
    return force;
  });
  step.contacts.balance(in.near, {inertial.begin(), inertial.end()});
}

/// Undoes a part of the compression for which no work was done, by displacements in addition to u.
void Minimiser::undoExcess(const Step& step, const VectorField& u) {
  if (!step_.excessive) return;
  recovery_.resize(step.in.particles.size());
  step_.recover(descent_.compression(), recovery_);
  step.contacts.stop(step.in.particles, u, recovery_);
}

}  // namespace tactile_clay::clay
