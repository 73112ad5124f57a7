#include "ultrasound/propagator.h"

#include <algorithm>

#include "ultrasound/piston_wave.h"

namespace tactile_clay::ultrasound {
namespace {

TACTILE_CLAY_CLONES float fillRow(const TransducerLanes& t, const PistonConstants& air, float strength,
                                  const float* point, ComplexLanes* row, ComplexLanes* direction) {
  Lanes reach{};
  for (std::size_t i = 0; i < t.x.size(); ++i) {
    const Lanes x = point[0] - t.x[i];
    const Lanes y = point[1] - t.y[i];
    const Lanes z = point[2] - t.z[i];
    Lanes amplitude;
    Lanes turns;
    Lanes cosine;
    Lanes sine;
    pistonWave(air, x, y, z, x * t.nx[i] + y * t.ny[i] + z * t.nz[i], amplitude, turns);
    unitCircle(turns, cosine, sine);
    amplitude *= strength;
    row[i] = {amplitude * cosine, amplitude * sine};
    const Lanes one_over = inverseRoot(larger(x * x + y * y + z * z, Lanes{} + 1e-12f));
    direction[i] = {x * one_over, y * one_over};
    reach += amplitude;
  }
  return sum(reach);
}

TACTILE_CLAY_CLONES void propagateRows(const Propagator& g, const ComplexLanes* q, float* re, float* im) {
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

TACTILE_CLAY_CLONES void backpropagateRows(const Propagator& g, const float* re, const float* im,
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

TACTILE_CLAY_CLONES void gramRow(const Propagator& g, std::size_t m, float* re, float* im) {
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
TACTILE_CLAY_CLONES float amplitudeRow(const ComplexLanes* row, const ComplexLanes* q, const Lanes* free,
                                       std::size_t width, float re, float im, Lanes* along, Lanes* j) {
  Lanes total{};
  for (std::size_t i = 0; i < width; ++i) {
    const Lanes x = row[i].re * q[i].re - row[i].im * q[i].im;
    const Lanes y = row[i].re * q[i].im + row[i].im * q[i].re;
    along[i] = x * re - y * im;
    j[i] = -free[i] * (x * im + y * re);
    total += along[i];
  }
  return sum(total);
}

/// The slopes along x and y, from a = `along` and -b = `across`.
TACTILE_CLAY_CLONES void slopeRows(const ComplexLanes* s, const Lanes* along, const Lanes* across,
                                   const Lanes* free, std::size_t width, float amplitude, float* slope,
                                   float* peak_width, Lanes* j) {
  const float over = 1.0f / amplitude;
  Lanes mean_x{};
  Lanes mean_y{};
  Lanes square_x{};
  Lanes square_y{};
  Lanes slope_x{};
  Lanes slope_y{};
  for (std::size_t i = 0; i < width; ++i) {
    const Lanes ax = along[i] * s[i].re;
    const Lanes ay = along[i] * s[i].im;
    mean_x += ax;
    mean_y += ay;
    square_x += ax * s[i].re;
    square_y += ay * s[i].im;
    slope_x -= across[i] * s[i].re;
    slope_y -= across[i] * s[i].im;
  }
  const float x = sum(mean_x) * over;
  const float y = sum(mean_y) * over;
  slope[0] = sum(slope_x) * over;
  slope[1] = sum(slope_y) * over;
  peak_width[0] = sum(square_x) * over - x * x;
  peak_width[1] = sum(square_y) * over - y * y;
  for (std::size_t i = 0; i < width; ++i) {
    const Lanes a = free[i] * along[i] * over;
    j[i] = a * (s[i].re - x);
    j[width + i] = a * (s[i].im - y);
  }
}

/// Products of row m with the rows up to it.
TACTILE_CLAY_CLONES void rowProductsOf(const Lanes* const* rows, std::size_t width, std::size_t m,
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

TACTILE_CLAY_CLONES void scaleLanes(ComplexLanes* a, std::size_t count, float factor) {
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
    const std::size_t i = n / lane_count;
    const std::size_t lane = n % lane_count;
    x[i][lane] = static_cast<float>(layout.position[n].x());
    y[i][lane] = static_cast<float>(layout.position[n].y());
    z[i][lane] = static_cast<float>(layout.position[n].z());
    nx[i][lane] = static_cast<float>(layout.normal[n].x());
    ny[i][lane] = static_cast<float>(layout.normal[n].y());
    nz[i][lane] = static_cast<float>(layout.normal[n].z());
  }
}

float Propagator::addFocus(const TransducerLanes& transducers, const Acoustics& acoustics,
                           const Eigen::Vector3d& point) {
  const Eigen::Vector3f at = point.cast<float>();
  const float reach =
      fillRow(transducers, PistonConstants(acoustics), static_cast<float>(acoustics.reference_pressure),
              at.data(), row(foci), &s[foci * width]);
  if (reach > 0.0f) ++foci;
  return reach;
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

void focusChange(const Propagator& g, const DriveLanes& q, const FocusField& p, const LaneArray<Lanes>& free,
                 bool slopes, FocusChange& change) {
  const auto foci = static_cast<Eigen::Index>(g.foci);
  const std::size_t width = g.width;
  const Eigen::ArrayXf scale = p.abs().max(1e-20f).inverse();
  change.amplitude.resize(foci);
  change.slope.resize(slopes ? 2 * foci : 0);
  change.peak_width.resize(slopes ? 2 * foci : 0);
  change.j.resize((slopes ? 3 : 1) * g.foci * width);
  LaneArray<Lanes> along(width);
  for (Eigen::Index k = 0; k < foci; ++k) {
    const auto m = static_cast<std::size_t>(k);
    Lanes* across = &change.j[m * width];
    change.amplitude(k) = amplitudeRow(g.row(m), q.data(), free.data(), width, p.re(k) * scale(k),
                                       -p.im(k) * scale(k), along.data(), across);
    if (slopes)
      slopeRows(&g.s[m * width], along.data(), across, free.data(), width,
                std::max(change.amplitude(k), 1e-20f), &change.slope(2 * k), &change.peak_width(2 * k),
                &change.j[(g.foci + 2 * m) * width]);
  }
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
