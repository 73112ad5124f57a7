#include "lanes/lane_matrix.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace tactile_clay::lane_matrix_test {
namespace {

constexpr int n = 6;

// Against the decomposition of Eigen in double precision: another system in each lane.
TEST(SolveSymmetric, SolvesEachLane) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  using Matrix = Eigen::Matrix<double, n, n>;
  using Vector = Eigen::Matrix<double, n, 1>;
  Lane a[n][n] = {}, b[n], x[n];
  Matrix matrix[lane_width];
  Vector right[lane_width];
  for (int lane = 0; lane < lane_width; ++lane) {
    const Matrix root = Matrix::NullaryExpr([&] { return static_cast<double>(normal(random)); });
    matrix[lane] = root * root.transpose() + 0.1 * Matrix::Identity();
    right[lane] = Vector::NullaryExpr([&] { return static_cast<double>(normal(random)); });
    for (int i = 0; i < n; ++i) {
      b[i][lane] = static_cast<float>(right[lane][i]);
      for (int j = 0; j <= i; ++j) a[i][j][lane] = static_cast<float>(matrix[lane](i, j));
    }
  }
  solveSymmetric(a, b, x);
  for (int lane = 0; lane < lane_width; ++lane) {
    const Vector expected = matrix[lane].ldlt().solve(right[lane]);
    // Single precision, times a condition number of some hundred.
    for (int i = 0; i < n; ++i)
      EXPECT_NEAR(static_cast<double>(x[i][lane]), expected[i], 1e-3 * expected.norm());
  }
}

TEST(SolveSymmetric, AnEmptySystemGivesZero) {
  Lane a[n][n] = {}, b[n] = {}, x[n];
  solveSymmetric(a, b, x);
  for (const Lane& value : x)
    for (int lane = 0; lane < lane_width; ++lane) EXPECT_EQ(value[lane], 0.0f);
}

}  // namespace
}  // namespace tactile_clay::lane_matrix_test
