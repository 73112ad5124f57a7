#include "ultrasound/propagator.h"

#include <algorithm>

namespace tactile_clay::ultrasound {
namespace {

/// @param moments sums over the row of a, a sx, a sy, a sz, a sx^2, a sx sy, a sx sz, a sy^2, a sy sz, a sz^2
TACTILE_CLAY_MULTIVERSION void fillRow(const TransducerLanes& t, const PistonConstants& air, float strength,
                                       const float* point, ComplexLanes* row, ComplexLanes* direction,
                                       float* moments) {
  constexpr std::size_t row_of[3] = {4, 6, 7};  // row_of[a] + b: index of the sum over a s_a s_b, b >= a
  Lanes total[10] = {};
  for (std::size_t i = 0; i < t.x.size(); ++i) {
    const LaneWaves w = wavesAt(t, i, air, strength, point);
    row[i] = w.pressure;
    const Lanes one_over = inverseRoot(max(w.squared, Lanes{} + 1e-12f));
    const Lanes s[3] = {w.x * one_over, w.y * one_over, w.z * one_over};
    direction[i] = {s[0], s[1]};
    total[0] += w.amplitude;
    for (std::size_t a = 0; a < 3; ++a) {
      const Lanes weighted = w.amplitude * s[a];
      total[1 + a] += weighted;
      for (std::size_t b = a; b < 3; ++b) total[row_of[a] + b] += weighted * s[b];
    }
  }
  for (std::size_t n = 0; n < 10; ++n) moments[n] = sum(total[n]);
}

TACTILE_CLAY_MULTIVERSION void propagateRows(const Propagator& g, const ComplexLanes* q, float* re,
                                             float* im) {
  for (std::size_t m = 0; m < g.foci; ++m) {
    const ComplexLanes* row = g.row(m);
    Lanes sum_re{};
    Lanes sum_im{};
    for (std::size_t i = 0; i < g.width; ++i) {
      sum_re += row[i].re * q[i].re - row[i].im * q[i].im;
      sum_im += row[i].re * q[i].im + row[i].im * q[i].re;
    }
    re[m] = sum(sum_re);
    im[m] = sum(sum_im);
  }
}

TACTILE_CLAY_MULTIVERSION void backpropagateRows(const Propagator& g, const float* re, const float* im,
                                                 ComplexLanes* q) {
  for (std::size_t i = 0; i < g.width; ++i) {
    Lanes sum_re{};
    Lanes sum_im{};
    for (std::size_t m = 0; m < g.foci; ++m) {
      const ComplexLanes& a = g.row(m)[i];
      sum_re += a.re * re[m] + a.im * im[m];
      sum_im += a.re * im[m] - a.im * re[m];
    }
    q[i] = {sum_re, sum_im};
  }
}

TACTILE_CLAY_MULTIVERSION void gramRow(const Propagator& g, std::size_t m, float* re, float* im) {
  const ComplexLanes* a = g.row(m);
  for (std::size_t k = 0; k <= m; ++k) {
    const ComplexLanes* b = g.row(k);
    Lanes sum_re{};
    Lanes sum_im{};
    for (std::size_t i = 0; i < g.width; ++i) {
      sum_re += a[i].re * b[i].re + a[i].im * b[i].im;
      sum_im += a[i].im * b[i].re - a[i].re * b[i].im;
    }
    re[k] = sum(sum_re);
    im[k] = sum(sum_im);
  }
}

/// (re, im) is conj(p) / |p|.
TACTILE_CLAY_MULTIVERSION float partsRow(const ComplexLanes* row, const ComplexLanes* q, std::size_t width,
                                         float re, float im, Lanes* along, Lanes* across) {
  Lanes total{};
  for (std::size_t i = 0; i < width; ++i) {
    const Lanes x = row[i].re * q[i].re - row[i].im * q[i].im;
    const Lanes y = row[i].re * q[i].im + row[i].im * q[i].re;
    along[i] = x * re - y * im;
    across[i] = -(x * im + y * re);
    total += along[i];
  }
  return sum(total);
}

/// @param moments sums of a sx, a sy, a sx^2, a sx sy, a sy^2, b sx, b sy
TACTILE_CLAY_MULTIVERSION void shapeMoments(const ComplexLanes* s, const Lanes* along, const Lanes* across,
                                            std::size_t width, float* moments) {
  Lanes total[7] = {};
  for (std::size_t i = 0; i < width; ++i) {
    const Lanes ax = along[i] * s[i].re;
    const Lanes ay = along[i] * s[i].im;
    total[0] += ax;
    total[1] += ay;
    total[2] += ax * s[i].re;
    total[3] += ax * s[i].im;
    total[4] += ay * s[i].im;
    total[5] -= across[i] * s[i].re;
    total[6] -= across[i] * s[i].im;
  }
  for (std::size_t n = 0; n < 7; ++n) moments[n] = sum(total[n]);
}

/// The shape of a focus along the unit vector u, and the factor of its rows.
struct Along {
  float ux, uy;
  float mean, square;  // of s u, weighted by a, and its variance
  float over;          // 1 / sum a
};

Along along(const FocusParts& parts, std::size_t m, const PeakShape& shape, const Eigen::Vector2f& u) {
  return {u.x(), u.y(), shape.mean.dot(u), u.dot(shape.width * u),
          1.0f / std::max(parts.amplitude(static_cast<Eigen::Index>(m)), 1e-20f)};
}

TACTILE_CLAY_MULTIVERSION void fillSlopeRow(const ComplexLanes* s, const Lanes* along, std::size_t width,
                                            Along u, Lanes* row) {
  for (std::size_t i = 0; i < width; ++i)
    row[i] = u.over * along[i] * (u.ux * s[i].re + u.uy * s[i].im - u.mean);
}

TACTILE_CLAY_MULTIVERSION void fillWidthRow(const ComplexLanes* s, const Lanes* across, std::size_t width,
                                            Along u, Lanes* row) {
  for (std::size_t i = 0; i < width; ++i) {
    const Lanes aside = u.ux * s[i].re + u.uy * s[i].im - u.mean;
    row[i] = u.over * across[i] * (aside * aside - u.square);
  }
}

/// Products of row m with the rows up to it.
TACTILE_CLAY_MULTIVERSION void rowProductsOf(const Lanes* const* rows, std::size_t width, std::size_t m,
                                             float* products) {
  const Lanes* row = rows[m];
  std::size_t k = 0;
  for (; k + 3 <= m; k += 4) {  // four at a time, so that each lane of the row is loaded once for them
    Lanes total[4] = {};
    for (std::size_t i = 0; i < width; ++i) {
      for (std::size_t n = 0; n < 4; ++n) total[n] += row[i] * rows[k + n][i];
    }
    for (std::size_t n = 0; n < 4; ++n) products[k + n] = sum(total[n]);
  }
  for (; k <= m; ++k) {
    Lanes total{};
    for (std::size_t i = 0; i < width; ++i) total += row[i] * rows[k][i];
    products[k] = sum(total);
  }
}

TACTILE_CLAY_MULTIVERSION void scaleLanes(ComplexLanes* a, std::size_t count, float factor) {
  for (std::size_t i = 0; i < count; ++i) {
    a[i].re *= factor;
    a[i].im *= factor;
  }
}

}  // namespace

TransducerLanes::TransducerLanes(const ArrayLayout& layout) {
  const std::size_t width = lanesFor(layout.size());
  for (LaneArray<Lanes>* lanes : {&x, &y, &z, &nx, &ny, &nz}) lanes->resize(width, Lanes{});
  for (std::size_t n = 0; n < layout.size(); ++n) {
    const std::size_t i = n / wide_lane_count;
    const std::size_t lane = n % wide_lane_count;
    x[i][lane] = static_cast<float>(layout.position[n].x());
    y[i][lane] = static_cast<float>(layout.position[n].y());
    z[i][lane] = static_cast<float>(layout.position[n].z());
    nx[i][lane] = static_cast<float>(layout.normal[n].x());
    ny[i][lane] = static_cast<float>(layout.normal[n].y());
    nz[i][lane] = static_cast<float>(layout.normal[n].z());
  }
}

FocusBeam Propagator::addFocus(const TransducerLanes& transducers, const Acoustics& acoustics,
                               const Eigen::Vector3d& point) {
  const Eigen::Vector3f at = point.cast<float>();
  float moments[10];
  fillRow(transducers, PistonConstants(acoustics), static_cast<float>(acoustics.reference_pressure),
          at.data(), row(foci), &s[foci * width], moments);
  FocusBeam beam;
  beam.reach = moments[0];
  if (!(beam.reach > 0.0f)) return beam;
  ++foci;
  for (float& moment : moments) moment /= beam.reach;
  const Eigen::Vector3f mean(moments[1], moments[2], moments[3]);
  beam.spread << moments[4], moments[5], moments[6],  //
      moments[5], moments[7], moments[8],             //
      moments[6], moments[8], moments[9];
  beam.spread -= mean * mean.transpose();
  return beam;
}

void Propagator::scaleRow(std::size_t m, float factor) {
  scaleLanes(row(m), width, factor);
}

void propagate(const Propagator& g, const DriveLanes& q, FocusField& p) {
  propagateRows(g, q.data(), p.re.data(), p.im.data());
}

void backpropagate(const Propagator& g, const FocusField& p, DriveLanes& q) {
  backpropagateRows(g, p.re.data(), p.im.data(), q.data());
}

Eigen::MatrixXcf gram(const Propagator& g) {
  const auto n = static_cast<Eigen::Index>(g.foci);
  Eigen::MatrixXcf r(n, n);
  Eigen::ArrayXf re(n);
  Eigen::ArrayXf im(n);
  for (Eigen::Index m = 0; m < n; ++m) {
    gramRow(g, static_cast<std::size_t>(m), re.data(), im.data());
    for (Eigen::Index k = 0; k <= m; ++k) {
      r(m, k) = {re(k), im(k)};
      r(k, m) = {re(k), -im(k)};
    }
  }
  return r;
}

void focusParts(const Propagator& g, const DriveLanes& q, const FocusField& p, FocusParts& parts) {
  const auto foci = static_cast<Eigen::Index>(g.foci);
  const Eigen::ArrayXf scale = p.abs().max(1e-20f).inverse();
  parts.amplitude.resize(foci);
  parts.along.resize(g.foci * g.width);
  parts.across.resize(g.foci * g.width);
  for (Eigen::Index k = 0; k < foci; ++k) {
    const std::size_t at = static_cast<std::size_t>(k) * g.width;
    parts.amplitude(k) = partsRow(&g.g[at], q.data(), g.width, p.re(k) * scale(k), -p.im(k) * scale(k),
                                  &parts.along[at], &parts.across[at]);
  }
}

PeakShape peakShape(const Propagator& g, const FocusParts& parts, std::size_t m) {
  const std::size_t at = m * g.width;
  float moments[7];
  shapeMoments(&g.s[at], &parts.along[at], &parts.across[at], g.width, moments);
  const float over = 1.0f / std::max(parts.amplitude(static_cast<Eigen::Index>(m)), 1e-20f);
  for (float& moment : moments) moment *= over;
  PeakShape shape;
  shape.slope = {moments[5], moments[6]};
  shape.mean = {moments[0], moments[1]};
  shape.width << moments[2], moments[3], moments[3], moments[4];
  shape.width -= shape.mean * shape.mean.transpose();
  return shape;
}

void slopeRow(const Propagator& g, const FocusParts& parts, std::size_t m, const PeakShape& shape,
              const Eigen::Vector2f& u, Lanes* row) {
  const std::size_t at = m * g.width;
  fillSlopeRow(&g.s[at], &parts.along[at], g.width, along(parts, m, shape, u), row);
}

void widthRow(const Propagator& g, const FocusParts& parts, std::size_t m, const PeakShape& shape,
              const Eigen::Vector2f& u, Lanes* row) {
  const std::size_t at = m * g.width;
  fillWidthRow(&g.s[at], &parts.across[at], g.width, along(parts, m, shape, u), row);
}

Eigen::MatrixXd rowProducts(const std::vector<const Lanes*>& rows, std::size_t width) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd products(n, n);
  Eigen::ArrayXf row(n);
  for (Eigen::Index m = 0; m < n; ++m) {
    rowProductsOf(rows.data(), width, static_cast<std::size_t>(m), row.data());
    for (Eigen::Index k = 0; k <= m; ++k) products(m, k) = products(k, m) = row(k);
  }
  return products;
}

}  // namespace tactile_clay::ultrasound
