#pragma once

#include "lanes/lane_matrix.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {

// The fabric of bonds: into which directions the bonds of a particle point. Flow needs it for the strain that
// it keeps.

/// Fourth moments of the bonds of a particle, J: sum k l^2 n n n n, the stress in a direction (row) that a
/// strain in a direction (column) causes. The order is xx, yy, zz, yz, zx, xy. It is symmetric; of equal
/// components only one is stored.
struct Moments {
  Lane xxxx, yyyy, zzzz, yyzz, zzxx, xxyy, xxyz, yyyz, zzyz, xxzx, yyzx, zzzx, xxxy, yyxy, zzxy;
};
TACTILE_CLAY_INLINE void addFourth(Moments& to, const Lane& weight, const LaneVector& x) {
  const Lane xx = x.x * x.x, yy = x.y * x.y, zz = x.z * x.z, yz = x.y * x.z, zx = x.z * x.x, xy = x.x * x.y;
  const Lane of_xx = weight * xx, of_yy = weight * yy, of_zz = weight * zz;
  to.xxxx += of_xx * xx;
  to.yyyy += of_yy * yy;
  to.zzzz += of_zz * zz;
  to.yyzz += of_yy * zz;
  to.zzxx += of_zz * xx;
  to.xxyy += of_xx * yy;
  to.xxyz += of_xx * yz;
  to.yyyz += of_yy * yz;
  to.zzyz += of_zz * yz;
  to.xxzx += of_xx * zx;
  to.yyzx += of_yy * zx;
  to.zzzx += of_zz * zx;
  to.xxxy += of_xx * xy;
  to.yyxy += of_yy * xy;
  to.zzxy += of_zz * xy;
}

// Weight of an isotropic fabric beside that of the bonds, for particles with few bonds.
constexpr float isotropic_weight = 0.02f;
// The same for the strain that flow keeps. With less, a heap stops up to 6 % short of where its yield stress
// carries it; with more, more of the stress at surfaces and in worked clay never fades.
constexpr float kept_isotropic_weight = 2.5f;

/// Mean strain v of bonds with stress T, for an isotropic fabric beside N = sum k l^2 n n. It is part of the
/// strain tensor v + E for which the bonds have their stress: sum k (l n)(v + n E n)(l n)^T = T. With the
/// fourth moments of an isotropic fabric: T = v N + 2 Q E / 15, tr T = Q v + E : N, Q = tr N.
TACTILE_CLAY_INLINE Lane nearlyIsotropicVolumeStrain(const Symmetric& t, const Symmetric& n) {
  const Lane square = trace(n), per_square = square > 0.0f ? 1.0f / square : Lane{};
  const Lane scale = 7.5f * per_square * per_square;
  const Symmetric uneven = deviator(n);
  const Lane mean = trace(t) * per_square - scale * product(t, uneven);
  // The denominator is bounded for particles with few bonds.
  return mean / max(1.0f - scale * product(uneven, uneven), all(0.5f));
}

/// The strain S for which bonds with the fourth moments M, and beside them an isotropic fabric of a weight,
/// have the stress t: M S + weight Q / 15 (tr S I + 2 S) = t, with Q = tr N.
TACTILE_CLAY_INLINE Symmetric strainUnder(const Symmetric& t, const Moments& m, const Lane& q, float weight) {
  const Lane w = weight / 15.0f * q;
  Lane lower[6][6] = {{m.xxxx + 3.0f * w},
                      {m.xxyy + w, m.yyyy + 3.0f * w},
                      {m.zzxx + w, m.yyzz + w, m.zzzz + 3.0f * w},
                      {m.xxyz, m.yyyz, m.zzyz, m.yyzz + w},
                      {m.xxzx, m.yyzx, m.zzzx, m.zzxy, m.zzxx + w},
                      {m.xxxy, m.yyxy, m.zzxy, m.yyzx, m.xxyz, m.xxyy + w}};
  const Lane right[6] = {t.xx, t.yy, t.zz, t.yz, t.zx, t.xy};
  Lane strain[6];
  solveSymmetric(lower, right, strain);
  return {strain[0], strain[1], strain[2], strain[3], strain[4], strain[5]};
}

/// The strain that flow keeps. Its trace is that of the strain tensor S that fits the strains of the bonds
/// best, the minimum of sum k l^2 (strain - n S n)^2, so M S = T. An isotropic fabric with its own solution
/// is added with a small weight: with fewer than six bonds M is singular. The plain mean strain of the bonds,
/// or fourth moments of an isotropic fabric, would let clay that goes on flowing have another volume: bonds
/// turn into the direction of the flow.
///
/// The strain that is kept is the multiple of X with this trace, where M X = I: it causes the same stress in
/// all directions. Any other would leave a deviatoric stress that no flow reduces. To M an isotropic fabric
/// is added here, too, see `kept_isotropic_weight`.
TACTILE_CLAY_INLINE Symmetric volumeStrain(const Symmetric& t, const Moments& m) {
  const Symmetric n{m.xxxx + m.xxyy + m.zzxx, m.xxyy + m.yyyy + m.yyzz, m.zzxx + m.yyzz + m.zzzz,
                    m.xxyz + m.yyyz + m.zzyz, m.xxzx + m.yyzx + m.zzzx, m.xxxy + m.yyxy + m.zzxy};
  const Lane q = trace(n), v = nearlyIsotropicVolumeStrain(t, n), mean = v * q / 3.0f, none{};
  const Symmetric even{all(1.0f), all(1.0f), all(1.0f), none, none, none};
  const Symmetric own = sum(deviator(sum(t, times(-v, n))), times(mean, even));
  const Symmetric s = strainUnder(sum(t, times(all(isotropic_weight), own)), m, q, isotropic_weight);
  const Symmetric x = strainUnder(even, m, q, kept_isotropic_weight);
  return times(q > 0.0f ? trace(s) / trace(x) : Lane{}, x);
}

}  // namespace tactile_clay::clay
