#include "clay/forces/density.h"

#include <algorithm>
#include <cmath>

#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

constexpr float recovery_speed = 0.5f;   // m/s, of compression that nothing did work for
constexpr float forgiven_speed = 0.1f;   // m/s, of the energy that a particle is given in a step
constexpr float recovery_share = 0.25f;  // of it at a time, since neighbours undo each other's too

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

/// The work of a pressure kappa C on clay whose volume is V / (1 + C) is kappa V C / (1 + C)^2 dC. So that it
/// is the same for a step, and V up to twice the density, the stiffness has the factor (2 / ratio)^2 of the
/// start.
///
/// Some is compressed beyond by rounding and by what is linear; that may push. What a particle is lent for it
/// in a step is no more than its energy at `recovery_speed`, and what it may keep of that for the next is no
/// more than at `forgiven_speed`: what stays squeezed by others would be lent it again and again.
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

/// Along its gradient, C_i alone is undone by displacements of all neighbours together of C_i over the
/// gradient's length.
void recoverBeyond(const PairArrays& pairs, const DensityConstraints& of, float farthest, float dt,
                   Compression& used, VectorField& w) {
  farthest = std::min(recovery_speed * dt, farthest);  // gradients are of the start
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
    // Of many that are squeezed into one place, as in a closing fist, it would add up to a leap.
    for (std::size_t i = first; i < last; ++i)
      if (w[i].norm() > 2.0f * farthest) w[i] *= 2.0f * farthest / w[i].norm();
  });
}

}  // namespace tactile_clay::clay
