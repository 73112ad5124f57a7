#include "ultrasound/fixed_propagator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>
#include <random>
#include <vector>

namespace tactile_clay::ultrasound::fixed_propagator_test {
namespace {

using Complex = std::complex<double>;
using Row = std::vector<Complex>;

class FixedPropagatorOf : public ::testing::TestWithParam<std::size_t> {
 protected:
  /// Rows of transducers of amplitude 0.5 to 1 in any phase, times a factor of each row from 1e-3 to 1e3.
  void fill(std::size_t rows, std::size_t transducers) {
    std::mt19937 random(7);
    const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
    width_ = lanesFor(transducers);
    g_.emplace(rows, width_);
    for (std::size_t m = 0; m < rows; ++m) {
      const double factor = std::pow(10.0, 6.0 * uniform() - 3.0);
      rows_.emplace_back();
      reach_.push_back(0.0);
      for (std::size_t n = 0; n < transducers; ++n) {
        rows_.back().push_back(std::polar(factor * (0.5 + 0.5 * uniform()), 2.0 * M_PI * uniform()));
        reach_.back() += std::abs(rows_.back().back());
      }
      g_->setRow(m, lanesOf(rows_.back()).data(), static_cast<float>(reach_.back()));
    }
  }

  LaneArray<ComplexLanes> lanesOf(const Row& row) const {
    LaneArray<ComplexLanes> lanes(width_, ComplexLanes{});
    for (std::size_t n = 0; n < row.size(); ++n) {
      lanes[n / wide_lane_count].re[n % wide_lane_count] = static_cast<float>(row[n].real());
      lanes[n / wide_lane_count].im[n % wide_lane_count] = static_cast<float>(row[n].imag());
    }
    return lanes;
  }

  Row pressures(const Row& q) {
    std::vector<float> re(rows_.size()), im(rows_.size());
    g_->pressures(lanesOf(q).data(), re.data(), im.data());
    Row p;
    for (std::size_t m = 0; m < rows_.size(); ++m) p.emplace_back(re[m], im[m]);
    return p;
  }

  Row transposed(const Row& u) {
    std::vector<float> re, im;
    for (const Complex& x : u) {
      re.push_back(static_cast<float>(x.real()));
      im.push_back(static_cast<float>(x.imag()));
    }
    LaneArray<ComplexLanes> z(width_);
    g_->transposed(re.data(), im.data(), z.data());
    Row sums;
    for (std::size_t n = 0; n < rows_.front().size(); ++n)
      sums.emplace_back(z[n / wide_lane_count].re[n % wide_lane_count],
                        z[n / wide_lane_count].im[n % wide_lane_count]);
    return sums;
  }

  static Row random(std::size_t count, unsigned seed) {
    std::mt19937 engine(seed);
    Row values;
    for (std::size_t k = 0; k < count; ++k)
      values.push_back(std::polar(1.0, 2.0 * M_PI * engine() / 4294967296.0));
    return values;
  }

  std::size_t width_ = 0;
  std::optional<FixedPropagator> g_;
  std::vector<Row> rows_;
  std::vector<double> reach_;
};

// Rounding moves each part of a number evenly by up to half a unit, a variance of 1/12 unit^2. Units are
// r/2^19 for the rows and 1/2^11 for q. So each part of the sum of N products has the variance (N (r/2^19)^2
// + (sum |g|^2) / 2^22) / 12.
TEST_P(FixedPropagatorOf, PressuresAreOffByTheRoundingOfTheirNumbers) {
  const std::size_t transducers = GetParam();
  fill(400, transducers);
  const Row q = random(transducers, 3);
  const Row p = pressures(q);
  double over_expected = 0.0;
  for (std::size_t m = 0; m < rows_.size(); ++m) {
    Complex sum = 0.0;
    double squares = 0.0, maximum = 0.0;
    for (std::size_t n = 0; n < transducers; ++n) {
      sum += rows_[m][n] * q[n];
      squares += std::norm(rows_[m][n]);
      maximum = std::max(maximum, std::abs(rows_[m][n]));
    }
    const double unit = std::max(reach_[m] / 524288.0, maximum / 16384.0);
    const double variance = (static_cast<double>(transducers) * unit * unit + squares / 4194304.0) / 12.0;
    over_expected += std::norm(p[m] - sum) / (2.0 * variance) / static_cast<double>(rows_.size());
  }
  EXPECT_NEAR(std::sqrt(over_expected), 1.0, 0.15);
}

// In a column, the rows are rounded as before. The unit of u is its largest part times the row's unit in 64
// rows, over 2^10.
TEST_P(FixedPropagatorOf, TransposedSumsAreOffByTheRoundingOfTheirNumbers) {
  const std::size_t transducers = GetParam();
  fill(400, transducers);
  Row u = random(400, 4);
  std::vector<double> unit;
  for (std::size_t m = 0; m < u.size(); ++m) {
    double maximum = 0.0;
    for (const Complex& g : rows_[m]) maximum = std::max(maximum, std::abs(g));
    unit.push_back(std::max(reach_[m] / 524288.0, maximum / 16384.0));
    u[m] /= reach_[m];  // so that rows count alike
  }
  const Row z = transposed(u);
  double over_expected = 0.0;
  for (std::size_t n = 0; n < transducers; ++n) {
    Complex sum = 0.0;
    double variance = 0.0;
    for (std::size_t first = 0; first < u.size(); first += 64) {
      double maximum = 0.0;
      const std::size_t end = std::min(first + 64, u.size());
      for (std::size_t m = first; m < end; ++m)
        maximum = std::max(maximum, unit[m] * std::max(std::abs(u[m].real()), std::abs(u[m].imag())));
      for (std::size_t m = first; m < end; ++m) {
        sum += rows_[m][n] * u[m];
        variance += (std::norm(u[m]) * unit[m] * unit[m] +
                     std::norm(rows_[m][n] / unit[m]) * std::pow(maximum / 1024.0, 2)) /
                    12.0;
      }
    }
    over_expected += std::norm(z[n] - sum) / (2.0 * variance) / static_cast<double>(transducers);
  }
  EXPECT_NEAR(std::sqrt(over_expected), 1.0, 0.15);
}

// If all are in phase, sums are as large as possible.
TEST_P(FixedPropagatorOf, NoSumIsTooLarge) {
  const std::size_t transducers = GetParam();
  fill(128, transducers);
  Row q;
  for (const Complex& g : rows_[5]) q.push_back(std::conj(g) / std::abs(g));
  EXPECT_NEAR(std::abs(pressures(q)[5]), reach_[5], 1e-3 * reach_[5]);
  Row u;
  double reach = 0.0;
  for (const Row& row : rows_) {
    u.push_back(std::conj(row[0]) / std::norm(row[0]));
    reach += 1.0;
  }
  EXPECT_NEAR(std::abs(transposed(u)[0]), reach, 2e-3 * reach);
}

TEST(FixedPropagator, IsExactEnoughForOneTransducer) {
  FixedPropagator g(4, 1);
  LaneArray<ComplexLanes> row(1, ComplexLanes{}), q(1, ComplexLanes{});
  row[0].re[0] = 30.0f;
  row[0].im[0] = 40.0f;
  q[0].re[0] = 1.0f;
  g.setRow(2, row.data(), 50.0f);
  g.scale(0.1f);
  float re[4], im[4];
  g.pressures(q.data(), re, im);
  EXPECT_NEAR(re[2], 3.0f, 1e-3f);
  EXPECT_NEAR(im[2], 4.0f, 1e-3f);
  EXPECT_EQ(re[0], 0.0f) << "a row that was not set";
}

INSTANTIATE_TEST_SUITE_P(Transducers, FixedPropagatorOf, ::testing::Values(64u, 249u, 1024u));

}  // namespace
}  // namespace tactile_clay::ultrasound::fixed_propagator_test
