#include "ultrasound/newton_steps.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tactile_clay::ultrasound {
namespace {

constexpr int max_steps = 40;
constexpr int peak_steps = 15;           // after which peaks that were not reached are given up
constexpr float tolerance = 5e-4f;       // of an amplitude: below it single precision gains nothing
constexpr double peak_tolerance = 7e-4;  // m, from a focus to the peak of its amplitude
constexpr float min_width = 0.35f;       // of a peak's parabola, over that of a focus that is alone
constexpr double first_damping = 1e-5;   // limits steps if no drive can separate the foci
constexpr double max_damping = 1e3;      // beyond it no step helps

/// Sets the columns of J to 0 for phases that are not free.
/// @param free 1 if a phase may change, otherwise 0
TACTILE_CLAY_MULTIVERSION void mask(const LaneArray<Lanes>& free, std::size_t rows, LaneArray<Lanes>& j) {
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < free.size(); ++i) j[k * free.size() + i] *= free[i];
  }
}

/// Turns each drive by the sum of lambda times its row, as an angle up to third order.
TACTILE_CLAY_MULTIVERSION void turnBy(const Lanes* const* rows, const float* lambda, std::size_t count,
                                      DriveLanes& q) {
  constexpr float maximum = 0.5f;  // rad per step: J is valid for small changes only
  for (std::size_t i = 0; i < q.size(); ++i) {
    Lanes angle{};
    for (std::size_t m = 0; m < count; ++m) angle += lambda[m] * rows[m][i];
    angle = max(min(angle, Lanes{} + maximum), Lanes{} - maximum);
    const Lanes cosine = inverseRoot(1.0f + angle * angle);
    const Lanes sine = angle * cosine;
    const ComplexLanes a = q[i];
    q[i] = {a.re * cosine - a.im * sine, a.re * sine + a.im * cosine};
  }
}

float meanSquareError(const Eigen::ArrayXf& amplitude) {
  return (amplitude / std::max(amplitude.mean(), tiny_amplitude) - 1.0f).square().mean();
}

/// What a focus lacks to be a peak close enough to its place.
struct PeakFault {
  PeakShape shape;
  Eigen::Vector2f narrowest = Eigen::Vector2f::UnitX();  // unit vector along which its parabola is flattest
  float lacking = 0.0f;                                  // share of the minimum width that it lacks along it
  float near = 1.0f;                                     // share of its slope that is allowed, at most 1

  bool none() const { return lacking == 0.0f && near == 1.0f; }
};

struct Faults {
  FocusParts parts;
  std::vector<PeakFault> peak;  // of each focus; empty if none has a shape
  float total = 0.0f;           // mean square error of amplitudes, plus weighted errors of slopes and widths
  bool none = false;
};

/// @param max_aside maximum of wavenumber times the distance from a focus to its peak
void assess(const Propagator& g, float max_aside, const std::vector<FocusShape>& shapes, const DriveLanes& q,
            const FocusField& p, Faults& faults) {
  constexpr float slope_weight = 3.0f;  // of slopes; their s is about 0.3
  constexpr float width_weight = 0.03f;
  focusParts(g, q, p, faults.parts);
  faults.total = meanSquareError(faults.parts.amplitude);
  faults.none = worstError(faults.parts.amplitude) < tolerance;
  faults.peak.resize(shapes.size());
  const float over_foci = 1.0f / static_cast<float>(g.foci);
  for (std::size_t m = 0; m < shapes.size(); ++m) {
    if (!shapes[m].peak) continue;
    PeakFault& peak = faults.peak[m];
    peak = PeakFault();
    peak.shape = peakShape(g, faults.parts, m);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> along;
    along.computeDirect(peak.shape.width);
    const float minimum = min_width * shapes[m].width;
    peak.lacking = std::max(1.0f - along.eigenvalues()(0) / minimum, 0.0f);
    peak.narrowest = along.eigenvectors().col(0);
    const Eigen::Vector2f aside = (along.eigenvectors().transpose() * peak.shape.slope).array() /
                                  along.eigenvalues().array().max(minimum);
    peak.near = std::min(max_aside / std::max(aside.norm(), tiny_amplitude), 1.0f);
    if (!peak.none()) faults.none = false;
    faults.total += over_foci * (slope_weight * ((1.0f - peak.near) * peak.shape.slope).squaredNorm() +
                                 width_weight * peak.lacking * peak.lacking);
  }
}

/// Gives up the peaks that were not reached, so that the amplitudes can be reached.
/// @return whether there were any
bool giveUpPeaks(const Faults& faults, std::vector<FocusShape>& shapes) {
  bool any = false;
  for (std::size_t m = 0; m < shapes.size(); ++m) {
    if (!shapes[m].peak || faults.peak[m].none()) continue;
    shapes[m].peak = false;
    any = true;
  }
  return any;
}

/// J dphi = wanted, by rows: amplitudes first, then the widths and slopes of peaks that have a fault.
class Equations {
 public:
  explicit Equations(std::size_t shapes) : slope_held_(shapes, false) {}

  void set(const Propagator& g, const std::vector<FocusShape>& shapes, const Faults& faults,
           const LaneArray<Lanes>& free) {
    // Share of the allowed slope: a step aims below the limit, so that it meets the limit.
    constexpr float well_near = 0.6f;
    constexpr float well_wide = 1.3f;
    wanted_.clear();
    j_.resize((g.foci + 3 * shapes.size()) * g.width);
    const auto row = [&] { return &j_[wanted_.size() * g.width]; };
    const float mean = faults.parts.amplitude.mean();
    std::copy(faults.parts.across.begin(), faults.parts.across.end(), j_.begin());
    for (std::size_t m = 0; m < g.foci; ++m)
      wanted_.push_back(mean - faults.parts.amplitude(static_cast<Eigen::Index>(m)));
    for (std::size_t m = 0; m < shapes.size(); ++m) {
      if (!shapes[m].peak) continue;
      const PeakFault& peak = faults.peak[m];
      if (peak.lacking > 0.0f) {
        widthRow(g, faults.parts, m, peak.shape, peak.narrowest, row());
        wanted_.push_back(min_width * shapes[m].width * (well_wide - 1.0f + peak.lacking));
      }
      slope_held_[m] = slope_held_[m] || peak.near < 1.0f;
      if (!slope_held_[m]) continue;
      const float keep = peak.near < 1.0f ? well_near * peak.near : 1.0f;
      for (const Eigen::Vector2f& u : {Eigen::Vector2f(1.0f, 0.0f), Eigen::Vector2f(0.0f, 1.0f)}) {
        slopeRow(g, faults.parts, m, peak.shape, u, row());
        wanted_.push_back((keep - 1.0f) * peak.shape.slope.dot(u));
      }
    }
    rows_.clear();
    for (std::size_t k = 0; k < wanted_.size(); ++k) rows_.push_back(&j_[k * g.width]);
    mask(free, rows_.size(), j_);
    products_ = rowProducts(rows_, g.width);
  }

  /// Turns q by the smallest change that meets the equations, damped.
  /// @return false if there is none
  bool step(double damping, DriveLanes& q) const {
    Eigen::MatrixXd damped = products_;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-30;
    const Eigen::VectorXf lambda =
        damped.llt().solve(Eigen::Map<const Eigen::VectorXd>(wanted_.data(), damped.rows())).cast<float>();
    if (!lambda.allFinite()) return false;
    turnBy(rows_.data(), lambda.data(), rows_.size(), q);
    return true;
  }

 private:
  LaneArray<Lanes> j_;
  std::vector<const Lanes*> rows_;
  std::vector<double> wanted_;
  std::vector<bool> slope_held_;  // of each focus: whether its slope has been too large
  Eigen::MatrixXd products_;      // J J^T
};

}  // namespace

float worstError(const Eigen::ArrayXf& amplitude) {
  return (amplitude / std::max(amplitude.mean(), tiny_amplitude) - 1.0f).abs().maxCoeff();
}

void newtonSteps(const Propagator& g, double wavenumber, const LaneArray<Lanes>& free,
                 std::vector<FocusShape>& shapes, DriveLanes& q, FocusField& p) {
  const auto max_aside = static_cast<float>(wavenumber * peak_tolerance);
  Faults now;
  Faults after;
  DriveLanes trial;
  FocusField reached(g.foci);
  Equations equations(shapes.size());
  propagate(g, q, p);
  assess(g, max_aside, shapes, q, p, now);
  double damping = first_damping;
  bool moved = true;
  for (int step = 0; step < max_steps && !now.none; ++step) {
    if (damping > max_damping || step == peak_steps) {
      if (giveUpPeaks(now, shapes)) {
        assess(g, max_aside, shapes, q, p, now);
        damping = first_damping;
        moved = true;
      } else if (damping > max_damping) {
        return;
      }
    }
    if (moved) equations.set(g, shapes, now, free);
    trial = q;
    if (!equations.step(damping, trial)) return;
    propagate(g, trial, reached);
    assess(g, max_aside, shapes, trial, reached, after);
    moved = after.total < now.total;
    damping *= moved ? 0.1 : 10.0;
    if (!moved) continue;
    q.swap(trial);
    std::swap(p, reached);
    std::swap(now, after);
  }
}

}  // namespace tactile_clay::ultrasound
