#include "ultrasound/field_objective.h"

#include <algorithm>

#include "ultrasound/propagator.h"
#include "ultrasound/turns.h"

namespace tactile_clay::ultrasound {
namespace {

constexpr double enough_width = 0.5;  // d of the objective

/// Sums of the amplitudes of a row.
struct RowSums {
  float free, on_skin;  // Pa, of the waves at the point, and of what counts of them on its skin
};

/// The waves of all transducers at a point, as they count on skin (onSkin).
/// @param normal of the skin, of length 1 or 0
TACTILE_CLAY_MULTIVERSION RowSums fillRowOfSample(const TransducerLanes& t, const PistonConstants& air,
                                                  float strength, const float* point, const float* normal,
                                                  ComplexLanes* row) {
  Lanes total{}, on_skin{};
  for (std::size_t i = 0; i < t.x.size(); ++i) {
    const LaneWaves w = wavesAt(t, i, air, strength, point);
    const Lanes counts = onSkin(w.x, w.y, w.z, Lanes{} + normal[0], Lanes{} + normal[1], Lanes{} + normal[2]);
    row[i] = {counts * w.pressure.re, counts * w.pressure.im};
    total += w.amplitude;
    on_skin += counts * w.amplitude;
  }
  return {sum(total), sum(on_skin)};
}

TACTILE_CLAY_MULTIVERSION void toUnit(const Turns& turns, LaneArray<ComplexLanes>& q) {
  for (std::size_t i = 0; i < turns.size(); ++i) unitCircle(turns[i], q[i].re, q[i].im);
}

TACTILE_CLAY_MULTIVERSION void toTurns(const ComplexLanes* z, std::size_t width, Lanes* turns) {
  for (std::size_t i = 0; i < width; ++i) turns[i] = turnsOf(z[i].re, z[i].im);
}

/// factor Im(q z) of each transducer.
TACTILE_CLAY_MULTIVERSION void imaginaryPart(const LaneArray<ComplexLanes>& q,
                                             const LaneArray<ComplexLanes>& z, float factor, Turns& out) {
  for (std::size_t i = 0; i < q.size(); ++i) out[i] = factor * (q[i].re * z[i].im + q[i].im * z[i].re);
}

}  // namespace

FieldObjective::FieldObjective(const ArrayLayout& layout, const Acoustics& acoustics,
                               const std::vector<FocalPoint>& targets, const FieldSolverOptions& options)
    : strength_(options.strength),
      patterns_(static_cast<std::size_t>(options.patterns)),
      width_(lanesFor(layout.size())),
      count_(targets.size()),
      rows_((count_ + FixedPropagator::block - 1) / FixedPropagator::block * FixedPropagator::block),
      g_(rows_, width_),
      wanted_(rows_, 0.0f),
      intensity_(rows_, 0.0f),
      re_(rows_ * patterns_, 0.0f),
      im_(rows_ * patterns_, 0.0f),
      q_(width_ * patterns_),
      z_(width_ * patterns_) {
  const TransducerLanes transducers(layout);
  const PistonConstants air(acoustics);
  LaneArray<ComplexLanes> row(width_);
  bool possible = false;  // whether any wanted pressure is: skin may face away from all transducers
  for (std::size_t m = 0; m < count_; ++m) {
    const Eigen::Vector3f at = targets[m].position.cast<float>();
    const Eigen::Vector3f normal = targets[m].normal.normalized().cast<float>();  // a zero stays zero
    const RowSums sums = fillRowOfSample(transducers, air, static_cast<float>(acoustics.reference_pressure),
                                         at.data(), normal.data(), row.data());
    reach_.push_back(sums.free);
    if (sums.on_skin > 0.0f) g_.setRow(m, row.data(), sums.on_skin);
    unit_ = std::max(unit_, targets[m].intensity * reach_[m]);
    possible = possible || (targets[m].intensity > 0.0 && sums.on_skin > 0.0f);
  }
  if (!possible) unit_ = 0.0;
  if (!(unit_ > 0.0)) return;
  g_.scale(static_cast<float>(options.amplitude / unit_));
  for (std::size_t m = 0; m < count_; ++m) {
    wanted_[m] = static_cast<float>(std::pow(targets[m].intensity * reach_[m] / unit_, 2));
    weight_.push_back(static_cast<float>(targets[m].weight));
    plain_ = plain_ && targets[m].weight == 1.0;
  }
  blur_ = SkinBlur(targets, options.blur);
  plain_ = plain_ && blur_.none();
  for (auto* values : {&felt_wanted_, &felt_, &slope_, &felt_slope_}) values->assign(rows_, 0.0f);
  felt_wanted_ = felt(wanted_, felt_wanted_);
  for (std::size_t m = 0; m < count_; ++m)
    wanted_square_ += static_cast<double>(weight_[m]) * felt_wanted_[m] * felt_wanted_[m];
  if (!(wanted_square_ > 0.0)) unit_ = 0.0;  // no target with a wanted pressure has a weight
}

/// The values, blurred as skin blurs them.
/// @param blurred memory for the result
const std::vector<float>& FieldObjective::felt(const std::vector<float>& values,
                                               std::vector<float>& blurred) const {
  if (blur_.none()) return values;
  blur_.apply(values, blurred);
  return blurred;
}

/// Sets the derivatives of the objective by the intensities, from its derivatives by the sums.
void FieldObjective::setSlopes(double on_wanted, double on_intensity) {
  const std::vector<float>& had = blur_.none() ? intensity_ : felt_;
  std::vector<float>& slope = blur_.none() ? slope_ : felt_slope_;
  for (std::size_t m = 0; m < count_; ++m)
    slope[m] = static_cast<float>(weight_[m] * (on_wanted * felt_wanted_[m] + on_intensity * had[m]));
  if (!blur_.none()) blur_.applyTransposed(felt_slope_, slope_);
}

Turns FieldObjective::start() {
  Turns turns(size());
  constexpr double golden = 0.6180339887498949;  // golden ratio: multiples whose fractions do not repeat
  for (std::size_t k = 0; k < patterns_; ++k) {
    ComplexLanes* z = &z_[k * width_];
    for (std::size_t m = 0; m < rows_; ++m) {
      const double angle = 2.0 * M_PI * std::fmod(golden * static_cast<double>(k * (m + 1)), 1.0);
      re_[m] = std::sqrt(wanted_[m]) * static_cast<float>(std::cos(angle));
      im_[m] = std::sqrt(wanted_[m]) * static_cast<float>(std::sin(angle));
    }
    g_.transposed(re_.data(), im_.data(), z);
    toTurns(z, width_, &turns[k * width_]);
  }
  // To arrive in phase, sound is sent earlier by the time of its way: phases of G^H, minus those of G^T.
  for (Lanes& lane : turns) lane *= -1.0f;
  return turns;
}

double FieldObjective::operator()(const Turns& turns, Turns* gradient) {
  toUnit(turns, q_);
  std::fill(intensity_.begin(), intensity_.end(), 0.0f);
  const float share = 1.0f / static_cast<float>(patterns_);
  for (std::size_t k = 0; k < patterns_; ++k) {
    float* re = &re_[k * rows_];
    float* im = &im_[k * rows_];
    g_.pressures(&q_[k * width_], re, im);
    for (std::size_t m = 0; m < rows_; ++m) intensity_[m] += share * (re[m] * re[m] + im[m] * im[m]);
  }
  double both = 0.0;
  double had = 0.0;
  const std::vector<float>& now = felt(intensity_, felt_);
  for (std::size_t m = 0; m < count_; ++m) {
    both += static_cast<double>(weight_[m]) * now[m] * felt_wanted_[m];
    had += static_cast<double>(weight_[m]) * now[m] * now[m];
  }
  constexpr double tiny = 1e-30;  // for a field that misses all targets
  both = std::max(both / wanted_square_, tiny);
  had = std::max(had / wanted_square_, tiny);
  scale_ = both;
  square_error_ = 1.0 - both * both / had;
  const double missing = std::max(-std::log(both), 0.0);
  const bool much = missing > enough_width;
  const double price = much ? missing - 0.5 * enough_width : missing * missing / (2.0 * enough_width);
  if (gradient == nullptr) return square_error_ + strength_ * price;

  const double price_slope = much ? 1.0 : missing / enough_width;
  const double on_wanted = (-2.0 * both / had - strength_ * price_slope / both) / wanted_square_;
  const double on_intensity = 2.0 * std::pow(both / had, 2) / wanted_square_;
  setSlopes(on_wanted, on_intensity);
  for (std::size_t k = 0; k < patterns_; ++k) {
    float* re = &re_[k * rows_];
    float* im = &im_[k * rows_];
    for (std::size_t m = 0; m < count_; ++m) {
      re[m] *= slope_[m];
      im[m] *= -slope_[m];
    }
    g_.transposed(re, im, &z_[k * width_]);
  }
  // dI/dphi = 2 Re(conj(p) i G q) = -2 Im(conj(p) G q), times 2 pi for a phase in turns.
  imaginaryPart(q_, z_, -2.0f * two_pi * share, *gradient);
  return square_error_ + strength_ * price;
}

}  // namespace tactile_clay::ultrasound
