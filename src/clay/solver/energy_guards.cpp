// Members of Minimiser that keep a step from gaining energy if it was not solved to the end, or if colliders
// pushed the clay.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "clay/solver/minimiser.h"

namespace tactile_clay::clay {
namespace {

// m/s; a gain below the kinetic energy at this speed is ignored, as the tests of stability ignore it.
constexpr float unnoticed_gain = 0.02f;
// Share of the kinetic energy. If contacts pulled with less work than this share, their pull is not the
// reason why clay is too fast.
constexpr double min_pull = 0.01;
// A gain below this share of m (v^2 + unnoticed_speed^2) is not looked for. The speed is in m/s. For v = 0
// this is m (2 mm/s)^2.
constexpr double unnoticed_share = 1e-3, unnoticed_speed = 0.06;
// Halvings of the interval in which the share of u is searched. The share is then known to a millionth.
constexpr int halvings = 20;

}  // namespace

/// Whether the clay gained more kinetic energy than gravity and pushing colliders can explain, and contacts
/// that pulled clay onto solids may be the reason.
/// @param pulled J, work of these contacts
bool Minimiser::gainsByPull(const Step& step, double pulled, const VectorField& u) {
  if (!(pulled > 0.0)) return false;
  const StepInput& in = step.in;
  const Eigen::Vector3f fall = in.dt * in.dt * step.goal.gravity;
  const float slow = unnoticed_gain * in.dt;
  const std::vector<float>& inertia = descent_.inertia();
  const Sums energies = energies_.of(in.particles.size(), [&](std::size_t first, std::size_t last) {
    Sums sums;  // kinetic energy; its growth beyond the work of gravity
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

/// Shortens the displacements of lumps that may have gained energy that nothing gave them. This concerns clay
/// without viscosity, bonds and friction, for two reasons. If a step goes far, the set of compressed
/// particles at its end may differ from that at the start of the last round. And `expel` takes no account of
/// energy. If a lump touches only colliders at rest, no collider is in the way of a shorter u. The energies
/// are convex. So their minimum along u is where the only force left along u is that of colliders that push
/// out clay inside of them. The lump is moved only this far. The step then gains no energy but the work of
/// these colliders.
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
  descent_.findResidual(descent, u);  // sets the compression at the shortened u
}

/// Whether any lump of `rests` may have gained energy: the residual opposes u, and its work against u exceeds
/// the work of pushing the lump out by more than the gain that is not looked for.
/// @param rests as of Lumps::slideOnWhatRests
/// @param work J, as of Lumps::workOfPushingOut
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

/// Solids push out clay that started inside of them, with work that was not paid for. If two solids squeeze
/// clay that has nowhere to go, the compression stores this work. Density then gives back that much
/// less energy.
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
