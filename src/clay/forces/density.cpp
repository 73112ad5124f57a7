#include "clay/forces/density.h"

#include <algorithm>
#include <cmath>

#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

// m/s, at which unpaid compression is undone; also the speed of the energy that a particle is lent in a step.
constexpr float recovery_speed = 0.5f;
// m/s, the speed of the energy that a particle may keep of this loan.
constexpr float forgiven_speed = 0.1f;
// Share of a constraint that is undone in a step, since neighbours undo each other's, too.
constexpr float recovery_share = 0.25f;

}  // namespace

void Compression::resize(std::size_t n) {
  for (auto* numbers : {&c, &active, &growth, &pressure, &pressure_change}) numbers->resize(n);
  squeezed.resize(n);
}

bool Compression::activate(const DensityConstraints& of, std::size_t first, std::size_t last) {
  bool any = false;
  for (std::size_t i = first; i < last; ++i) {
    c[i] += of.excess[i];
    active[i] = c[i] > 0.0f ? of.stiffness[i] : 0.0f;
    pressure[i] = active[i] * c[i];
    any = any || c[i] > 0.0f;
  }
  return any;
}

/// The work of a pressure kappa C on clay whose volume is V / (1 + C) is kappa V C / (1 + C)^2 dC. In a step
/// the factor 1 / (1 + C)^2 is constant: it is 1 up to twice the density, beyond that (2 / ratio)^2 with the
/// ratio at the start of the step.
///
/// Rounding and linearisation compress some particles more than was paid for; this part may push. For it a
/// particle is lent at most its energy at `recovery_speed` in a step. Of this loan it keeps at most the
/// energy at `forgiven_speed` for the next step: otherwise a particle that others keep squeezed would get the
/// loan again and again.
bool boundExcess(const Particles& particles, std::size_t first, std::size_t last, DensityConstraints& of) {
  bool any = false;
  for (std::size_t i = first; i < last; ++i) {
    const float share = 2.0f / std::max(of.ratio[i], 2.0f), stiff = share * share * of.bulk[i];
    of.stiffness[i] = stiff;
    of.beyond[i] = of.lent[i] = 0.0f;
    if (!(stiff > 0.0f)) continue;
    const float paid = particles.compression[i];
    const float paid_square = of.bulk[i] / stiff * paid * paid;
    const float per_square_speed = 1.0f / (stiff * particles.inverse_mass[i]);
    const float bounded =
        std::min(of.excess[i], std::sqrt(paid_square + per_square_speed * recovery_speed * recovery_speed));
    const float kept = std::sqrt(paid_square + per_square_speed * forgiven_speed * forgiven_speed);
    of.beyond[i] = of.excess[i] - bounded;
    of.excess[i] = bounded;
    of.lent[i] = bounded > kept ? bounded * bounded - kept * kept : 0.0f;
    any = any || of.beyond[i] > 0.0f;
  }
  return any;
}

float paidCompression(const DensityConstraints& of, const Compression& compression, std::size_t i) {
  const float c = compression.acting(i);
  if (!(c > 0.0f)) return 0.0f;
  return std::min(std::sqrt(of.stiffness[i] / of.bulk[i] * std::max(c * c - of.lent[i], 0.0f)), 1.0f);
}

double storedEnergy(const DensityConstraints& of, const Compression& compression, std::size_t i) {
  const double c = paidCompression(of, compression, i);
  return c > 0.0 ? 0.5 * of.bulk[i] * c * c : 0.0;
}

double slopeBeyondSet(const DensityConstraints& of, const Compression& compression, std::size_t i,
                      float step) {
  const float growth = compression.growth[i], c = compression.c[i] + step * growth;
  return static_cast<double>((c > 0.0f ? of.stiffness[i] : 0.0f) - compression.active[i]) * c * growth;
}

/// C_i alone is undone along its gradient if the displacements of all neighbours together have the length
/// C_i / |gradient|.
void recoverBeyond(const PairArrays& pairs, const DensityConstraints& of, float farthest, float dt,
                   Compression& used, VectorField& w) {
  farthest = std::min(recovery_speed * dt, farthest);  // since gradients are those of the start
  parallelRanges(w.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      w[i].setZero();
      const float undone = std::min(of.beyond[i], farthest * of.steepness[i]);
      used.pressure[i] = undone > 0.0f ? recovery_share * undone / (of.steepness[i] * of.steepness[i]) : 0.0f;
    }
  });
  const Pressing pressing{pairs, {used.pressure.data(), w.data()}, {}, used.squeezed.data(), true, true};
  parallelRanges(w.size(), range_size, [&](std::size_t first, std::size_t last) {
    pressing.add(first, last);
    // If many particles are squeezed into one place, as in a closing fist, displacements would add up to a
    // leap.
    for (std::size_t i = first; i < last; ++i)
      if (w[i].norm() > 2.0f * farthest) w[i] *= 2.0f * farthest / w[i].norm();
  });
}

}  // namespace tactile_clay::clay
