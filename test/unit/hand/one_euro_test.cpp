#include "hand/one_euro.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "support/shared_data.h"

namespace tactile_clay::hand::one_euro_test {
namespace {

struct Sample {
  double time, signal, noisy, filtered;
};

std::vector<Sample> samples(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::vector<Sample> found;
  while (std::getline(file, line)) {
    std::istringstream numbers(line);
    Sample s{};
    char comma = 0;
    numbers >> s.time >> comma >> s.signal >> comma >> s.noisy >> comma >> s.filtered;
    found.push_back(s);
  }
  return found;
}

// min_cutoff 1 Hz, beta 0.1, derivative_cutoff 1 Hz, 120 samples a second; numbers have six digits.
void expectTheAuthorsResult(const std::vector<Sample>& reference) {
  OneEuro<1> filter;
  Eigen::Matrix<double, 1, 1> x(reference[0].noisy);
  filter.reset(x);
  double worst = 0.0;
  for (std::size_t i = 1; i < reference.size(); ++i) {
    x[0] = reference[i].noisy;
    filter.filter(x, reference[i].time - reference[i - 1].time, {1.0, 0.1, 1.0});
    worst = std::max(worst, std::abs(filter.value()[0] - reference[i].filtered));
  }
  EXPECT_LE(worst, 3e-5);
}

TEST(OneEuro, IsTheAuthorsReference) {
  const auto reference = samples(TACTILE_CLAY_SOURCE_DIR "/test/unit/hand/one_euro_reference.csv");
  ASSERT_EQ(reference.size(), 300U);
  expectTheAuthorsResult(reference);
}

TEST(OneEuro, IsTheAuthorsReferenceToItsEnd) {
  const auto reference = samples(sharedData("oneeuro_groundTruth.csv").string());
  if (reference.empty()) GTEST_SKIP() << "no oneeuro_groundTruth.csv";
  EXPECT_GT(reference.size(), 1000U);
  expectTheAuthorsResult(reference);
}

// The filter once more as the paper writes it, by time constants: tau = 1 / (2 pi f), exponential smoothing
// by Te / (Te + tau).
struct Smoothing {
  bool begun = false;
  double last = 0.0;
  double operator()(double x, double frequency, double te) {
    const double tau = 1.0 / (2.0 * M_PI * frequency), share = te / (te + tau);
    last = begun ? share * x + (1.0 - share) * last : x;
    begun = true;
    return last;
  }
};

TEST(OneEuro, IsTheFormulasOnRandomData) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    const OneEuroConfig config{std::pow(10.0, 2.0 * unit(random) - 1.0),
                               std::pow(10.0, 4.0 * unit(random) - 2.0),
                               std::pow(10.0, 2.0 * unit(random) - 1.0)};
    OneEuro<1> filter;
    Smoothing position, speed;
    double signal = unit(random);
    filter.reset(Eigen::Matrix<double, 1, 1>(signal));
    position(signal, 1.0, 1.0);
    speed(0.0, 1.0, 1.0);
    for (int i = 0; i < 400; ++i) {
      const double te = 0.002 + 0.03 * unit(random);  // as a tracker that stutters
      signal += 0.1 * (unit(random) - 0.5) + (unit(random) < 0.01 ? 1.0 : 0.0);
      const double dx = speed((signal - position.last) / te, config.derivative_cutoff, te);
      const double expected = position(signal, config.min_cutoff + config.beta * std::abs(dx), te);
      filter.filter(Eigen::Matrix<double, 1, 1>(signal), te, config);
      ASSERT_NEAR(filter.value()[0], expected, 3e-5 * std::max(std::abs(expected), 1e-3))
          << trial << " " << i;
    }
  }
}

TEST(OneEuro, DoesNotDependOnTheAxes) {
  const OneEuroConfig config{1.0, 20.0, 1.0};
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).matrix();
  OneEuro<3> straight, turned;
  std::mt19937 random(3);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  straight.reset(Eigen::Vector3d::Zero());
  turned.reset(Eigen::Vector3d::Zero());
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x(0.1 * uniform(), 0.1 * uniform(), 0.1 * std::sin(0.1 * i));
    straight.filter(x, 0.01, config);
    turned.filter(turn * x, 0.01, config);
    ASSERT_NEAR((turned.value() - turn * straight.value()).norm(), 0.0, 1e-14);
  }
}

TEST(OneEuro, FollowsWhereThereIsNoCutoff) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  OneEuro<1> filter;
  filter.reset(Eigen::Matrix<double, 1, 1>(1.0));
  EXPECT_EQ(filter.filter(Eigen::Matrix<double, 1, 1>(5.0), 0.01, {infinite, 0.0, 1.0})[0], 5.0);
}

// About one axis, a rotation is its angle.
TEST(OneEuroRotation, FiltersTheAngleAboutAFixedAxis) {
  const OneEuroConfig config{1.0, 0.5, 1.0};
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 0.8, -0.2).normalized();
  OneEuroRotation rotations;
  OneEuro<1> angles;
  rotations.reset(Eigen::Quaterniond::Identity());
  angles.reset(Eigen::Matrix<double, 1, 1>(0.0));
  for (int i = 1; i < 300; ++i) {
    // Passes +-pi, and comes as either of the two quaternions of a rotation.
    const double angle = 4.0 * std::sin(0.02 * i);
    Eigen::Quaterniond q(Eigen::AngleAxisd(angle, axis));
    if (i % 3 == 0) q.coeffs() *= -1.0;
    rotations.filter(q, 0.01, config);
    angles.filter(Eigen::Matrix<double, 1, 1>(angle), 0.01, config);
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(angles.value()[0], axis));
    ASSERT_LT(rotations.value().angularDistance(expected), 1e-7) << i;
  }
}

TEST(OneEuroRotation, VectorAndRotationAreInverse) {
  for (const double angle : {0.0, 1e-13, 1e-9, 0.1, 2.0, 3.1}) {
    const Eigen::Vector3d vector = angle * Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
    Eigen::Quaterniond q = rotation(vector);
    EXPECT_NEAR((rotationVector(q) - vector).norm(), 0.0, 1e-12);
    q.coeffs() *= -1.0;
    EXPECT_NEAR((rotationVector(q) - vector).norm(), 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace tactile_clay::hand::one_euro_test
