#include "ultrasound/skin_blur.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tactile_clay::ultrasound::skin_blur_test {
namespace {

std::vector<FocalPoint> grid(int side, double step) {
  std::vector<FocalPoint> places;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      places.emplace_back();
      places.back().position = {step * i, step * j, 0.2};
    }
  return places;
}

TEST(SkinBlur, IsAGaussianMean) {
  const auto places = grid(9, 0.002);
  const SkinBlur blur(places, 0.003);
  std::vector<float> one(places.size(), 0.0f), blurred(places.size());
  one[40] = 1.0f;  // the middle
  blur.apply(one, blurred);
  for (std::size_t m = 0; m < places.size(); ++m) {
    double share = 0.0, total = 0.0;
    for (std::size_t n = 0; n < places.size(); ++n) {
      const double d = (places[m].position - places[n].position).norm();
      const double g = d <= 2.5 * 0.003 ? std::exp(-0.5 * d * d / (0.003 * 0.003)) : 0.0;
      total += g;
      if (n == 40) share = g;
    }
    EXPECT_NEAR(blurred[m], share / total, 1e-6);
  }
  const std::vector<float> even(places.size(), 3.0f);
  blur.apply(even, blurred);
  for (const float value : blurred) EXPECT_NEAR(value, 3.0f, 1e-5f) << "what is even stays so";
}

TEST(SkinBlur, TransposedIsTheTransposed) {
  const auto places = grid(7, 0.003);
  const SkinBlur blur(places, 0.004);
  std::mt19937 random(3);
  std::vector<float> a, b;
  for (std::size_t k = 0; k < places.size(); ++k) {
    a.push_back(static_cast<float>(random() % 100));
    b.push_back(static_cast<float>(random() % 100));
  }
  std::vector<float> blurred(places.size()), sums(places.size());
  blur.apply(a, blurred);
  blur.applyTransposed(b, sums);
  double left = 0.0, right = 0.0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    left += static_cast<double>(b[k]) * blurred[k];
    right += static_cast<double>(sums[k]) * a[k];
  }
  EXPECT_NEAR(left, right, 1e-5 * left);
}

TEST(SkinBlur, OfNothingIsNone) {
  EXPECT_TRUE(SkinBlur(grid(3, 0.002), 0.0).none());
  EXPECT_TRUE(SkinBlur().none());
  EXPECT_FALSE(SkinBlur(grid(3, 0.002), 0.001).none());
}

}  // namespace
}  // namespace tactile_clay::ultrasound::skin_blur_test
