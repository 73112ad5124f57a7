// What keeps a step from gaining energy where it was not solved to the end, or what is in its way moved it.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "clay/solver/minimiser.h"

namespace tactile_clay::clay {
namespace {

// m/s; a gain of less than the energy of this speed is left, as tests of stability leave it.
constexpr float unnoticed_gain = 0.02f;
// Of the energy of motion: where contacts pulled with less work than that, it is not why clay is too fast.
constexpr double min_pull = 0.01;
// Of the energy of motion, and of that at a speed, m/s: less than that, 2 mm/s, is not looked for.
constexpr double unnoticed_share = 1e-3, unnoticed_speed = 0.06;
// Of the way along u, whose end is then known to a millionth.
constexpr int halvings = 20;

}  // namespace

/// Whether the clay moves faster than gravity and what pushes on it can tell, and contacts that pulled it
/// onto them may be why.
/// @param pulled J, their work
bool Minimiser::gainsByPull(const Step& step, double pulled, const VectorField& u) {
  if (!(pulled > 0.0)) return false;
  const StepInput& in = step.in;
  const Eigen::Vector3f fall = in.dt * in.dt * step.goal.gravity;
  const float slow = unnoticed_gain * in.dt;
  const std::vector<float>& inertia = descent_.inertia();
  const Sums energies = energies_.of(in.particles.size(), [&](std::size_t first, std::size_t last) {
    Sums sums;  // kinetic, and what it grew by without the work of gravity
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector3f was = in.free.at(i) - fall, is = u.at(i);
      sums.first += 0.5f * inertia[i] * is.squaredNorm();
      sums.second +=
          inertia[i] * (0.5f * (is.squaredNorm() - was.squaredNorm() - slow * slow) - fall.dot(is));
    }
    return sums;
  });
  const std::vector<double> pushed = lumps_.workOfPushingOut(in, step.contacts);
  const double gain = std::accumulate(pushed.begin(), pushed.end(), energies.second, std::minus<>());
  return gain > 0.0 && pulled > min_pull * energies.first;
}

/// Where a step goes far, the set of compressed particles at its end is not that of the last round's start,
/// and `expel` knows no energy at all: clay that neither viscosity, bonds nor friction hold may then have
/// gained what nothing gave it. If it lies on what rests, all shorter ways along u are free too, and the
/// energies, which are convex, are at their minimum along u where no force is left along it but that of
/// colliders that push out what is inside of them; so far it goes. The step then gains no energy but their
/// work.
void Minimiser::shorten(const Step& step, VectorField& u) {
  if (step_.pairs.sprung) return;
  const StepInput& in = step.in;
  const ConjugateGradients::Step descent = descentOf(step);
  const std::vector<bool> rests = lumps_.slideOnWhatRests(in, step.contacts);
  if (std::none_of(rests.begin(), rests.end(), [](bool it) { return it; })) return;
  descent_.findResidual(descent, u);
  const VectorField& residual = descent_.residual();
  const std::vector<double> work = lumps_.workOfPushingOut(in, step.contacts);
  if (!mayGain(step, rests, work, u)) return;
  product_.resize(in.particles.size());
  descent_.multiply(descent, u, product_);
  std::vector<double> share(in.near.lumps(), 1.0), minimum(in.near.lumps(), 0.0),
      maximum(in.near.lumps(), 1.0);
  const auto slopesAtShares = [&] {
    return slopes_.of(in.near, in.particles.size(), [&](std::size_t i) {
      const double way = share[in.near.lump(i)] - 1.0;
      return LumpSums<1>::Sum(
          way * product_[i].dot(u[i]) - residual[i].dot(u[i]) +
          slopeBeyondSet(step_.density, descent_.compression(), i, static_cast<float>(way)));
    });
  };
  const auto whole = slopesAtShares();
  for (std::size_t l = 0; l < rests.size(); ++l)
    if (!rests[l] || whole[l][0] <= work[l]) minimum[l] = 1.0;
  for (int k = 0; k < halvings; ++k) {
    for (std::size_t l = 0; l < rests.size(); ++l) share[l] = 0.5 * (minimum[l] + maximum[l]);
    const auto slopes = slopesAtShares();
    for (std::size_t l = 0; l < rests.size(); ++l) (slopes[l][0] > work[l] ? maximum : minimum)[l] = share[l];
  }
  parallelFor(u.size(), range_size,
              [&](std::size_t i) { u[i] *= static_cast<float>(minimum[in.near.lump(i)]); });
  descent_.findResidual(descent, u);  // for the compression that is left
}

/// Whether a lump that rests has a force left against u that may have cost more than the work of pushing it
/// out, J, and what is not looked for.
bool Minimiser::mayGain(const Step& step, const std::vector<bool>& rests, const std::vector<double>& work,
                        const VectorField& u) {
  const StepInput& in = step.in;
  const double slow = unnoticed_speed * in.dt;
  const std::vector<float>& inertia = descent_.inertia();
  const VectorField& residual = descent_.residual();
  const auto slopes = slopes_and_motions_.of(in.near, in.particles.size(), [&](std::size_t i) {
    return LumpSums<2>::Sum(-static_cast<double>(residual[i].dot(u[i])),
                            inertia[i] * (u[i].squaredNorm() + slow * slow));
  });
  for (std::size_t l = 0; l < rests.size(); ++l)
    if (rests[l] && slopes[l][0] - work[l] > unnoticed_share * slopes[l][1]) return true;
  return false;
}

/// Solids push out what started inside of them, and nobody pays for that. Where two of them squeeze what has
/// nowhere to go, compression stores their work: density gives that much less back.
void Minimiser::keepCompression(const Step& step) {
  const StepInput& in = step.in;
  kept_.assign(in.near.lumps(), 1.0f);
  const std::vector<double> work = lumps_.workOfRecovery(in, step.contacts);
  if (std::none_of(work.begin(), work.end(), [](double w) { return w > 0.0; })) return;
  const auto stored = stored_.of(in.near, in.particles.size(), [&](std::size_t i) {
    return LumpSums<1>::Sum(storedEnergy(step_.density, descent_.compression(), i));
  });
  for (std::size_t l = 0; l < work.size(); ++l)
    if (work[l] > 0.0)
      kept_[l] =
          static_cast<float>(std::sqrt(std::max(1.0 - work[l] / std::max(stored[l][0], work[l]), 0.0)));
}

}  // namespace tactile_clay::clay
