#include "ultrasound/propagator.h"

#include "ultrasound/piston_wave.h"

namespace tactile_clay::ultrasound {
namespace {

TACTILE_CLAY_CLONES float fillRow(const TransducerLanes& t, const PistonConstants& air, float strength,
                                  const float* point, ComplexLanes* row) {
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

TACTILE_CLAY_CLONES void jacobianRow(const ComplexLanes* row, const ComplexLanes* q, const Lanes* free,
                                     std::size_t width, float re, float im, Lanes* j) {
  for (std::size_t i = 0; i < width; ++i) {
    const Lanes a = row[i].re * q[i].re - row[i].im * q[i].im;
    const Lanes b = row[i].re * q[i].im + row[i].im * q[i].re;
    j[i] = free[i] * (im * a - re * b);  // -Im(conj(p / |p|) G q)
  }
}

TACTILE_CLAY_CLONES void rowProductsOf(const Lanes* j, std::size_t width, std::size_t m, float* products) {
  for (std::size_t k = 0; k <= m; ++k) {
    Lanes total{};
    for (std::size_t i = 0; i < width; ++i) total += j[m * width + i] * j[k * width + i];
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
  const float reach = fillRow(transducers, PistonConstants(acoustics),
                              static_cast<float>(acoustics.reference_pressure), at.data(), row(foci));
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

void phaseJacobian(const Propagator& g, const DriveLanes& q, const FocusField& p,
                   const LaneArray<Lanes>& free, LaneArray<Lanes>& j) {
  const Eigen::ArrayXf scale = p.abs().max(1e-20f).inverse();
  for (std::size_t m = 0; m < g.foci; ++m) {
    const auto k = static_cast<Eigen::Index>(m);
    jacobianRow(g.row(m), q.data(), free.data(), g.width, p.re(k) * scale(k), p.im(k) * scale(k),
                &j[m * g.width]);
  }
}

Eigen::MatrixXd rowProducts(const LaneArray<Lanes>& j, std::size_t width) {
  const auto n = static_cast<Eigen::Index>(j.size() / width);
  Eigen::MatrixXd products(n, n);
  Eigen::ArrayXf row(n);
  for (Eigen::Index m = 0; m < n; ++m) {
    rowProductsOf(j.data(), width, static_cast<std::size_t>(m), row.data());
    for (Eigen::Index k = 0; k <= m; ++k) products(m, k) = products(k, m) = row(k);
  }
  return products;
}

}  // namespace tactile_clay::ultrasound
