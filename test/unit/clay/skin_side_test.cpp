#include "clay/contact/skin_side.h"

#include <gtest/gtest.h>

#include <numeric>

#include "clouds.h"
#include "support/setups.h"

namespace tactile_clay::clay::skin_side_test {
namespace {

constexpr float spacing = 0.005f, radius = 1.5f * spacing, dt = 1.0f / 240.0f;

std::vector<NearSample> within(const Skin& samples, const Eigen::Vector3f& x, float far) {
  std::vector<NearSample> near;
  for (std::uint32_t g = 0; g < samples.size(); ++g) {
    const float square = (x - samples.position[g]).squaredNorm();
    if (square < far * far) near.push_back({g, square});
  }
  return near;
}

/// Clay between two fingers: their skins face each other, one spacing apart.
Skin twoFingers() {
  const float half = 0.5f * spacing;
  Skin samples = samplePlane({0.0, 0.0, -half}, Eigen::Vector3d::UnitZ(), 0.01, 0.002, {0.1, 0.0, 0.0});
  append(samples, samplePlane({0.0, 0.0, half}, -Eigen::Vector3d::UnitZ(), 0.01, 0.002, {0.0, 0.2, 0.0}));
  return samples;
}

TEST(SkinSide, TheNearestComesFirstAndEachSampleIsOfOneSide) {
  const Skin samples = twoFingers();
  const Eigen::Vector3f x(0.0003f, 0.0004f, 0.1f * spacing);  // nearer to the upper finger
  std::vector<NearSample> rest = within(samples, x, radius), upper, lower;
  const std::size_t all = rest.size();
  takeSide(samples, rest, upper);
  takeSide(samples, rest, lower);
  EXPECT_TRUE(rest.empty());
  EXPECT_EQ(upper.size() + lower.size(), all);
  ASSERT_GT(upper.size(), 5u);
  ASSERT_GT(lower.size(), 5u);
  for (const NearSample& g : upper) EXPECT_LT(samples.normal[g.sample].z(), 0.0f);
  for (const NearSample& g : lower) EXPECT_GT(samples.normal[g.sample].z(), 0.0f);
}

TEST(SkinSide, SamplesOfACurvedSkinWithinTheAngleAreOneSide) {
  Skin samples;
  // cosine to the first: within `same_side` and beyond it
  for (const float cosine : {1.0f, 0.5f, Contact::same_side + 0.01f, Contact::same_side - 0.01f, -1.0f}) {
    samples.position.emplace_back(0.001f * static_cast<float>(samples.size()), 0.0f, 0.0f);
    samples.normal.emplace_back(std::sqrt(1.0f - cosine * cosine), 0.0f, cosine);
    samples.velocity.emplace_back(0.0f, 0.0f, 0.0f);
  }
  std::vector<NearSample> rest = within(samples, Eigen::Vector3f::Zero(), 1.0f), side;
  takeSide(samples, rest, side);
  EXPECT_EQ(side.size(), 3u);
  EXPECT_EQ(rest.size(), 2u);
}

/// The mean of planes that are one is that plane, whatever the weights.
TEST(SkinSide, ThePlaneOfAFlatSkinIsExact) {
  std::mt19937 random(4);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d normal = randomVector(random, 1.0f).normalized().cast<double>();
    const Eigen::Vector3d velocity = randomVector(random, 0.5f).cast<double>();
    const Skin samples = samplePlane(Eigen::Vector3d::Zero(), normal, 0.015, 0.002, velocity);
    const Eigen::Vector3f x = randomVector(random, 0.5f * spacing);
    const std::vector<NearSample> near = within(samples, x, radius);
    ASSERT_GT(near.size(), 5u);
    std::vector<SampleShare> shares = {{7, 0.25f}};  // of another contact
    const SkinPlane plane = planeOf(samples, near, x, radius, dt, shares);
    const float distance = static_cast<float>(normal.dot(x.cast<double>()));
    EXPECT_NEAR((plane.normal.cast<double>() - normal).norm(), 0.0, 1e-5);
    EXPECT_NEAR(plane.distance, distance, 1e-7f);
    EXPECT_NEAR(plane.before, distance + dt * static_cast<float>(normal.dot(velocity)), 1e-7f);
    EXPECT_NEAR((plane.drift - dt * velocity.cast<float>()).norm(), 0.0f, 1e-7f);
    ASSERT_EQ(shares.size(), near.size() + 1);
    EXPECT_EQ(shares[0].share, 0.25f);
    const float sum = std::accumulate(shares.begin() + 1, shares.end(), 0.0f,
                                      [](float s, const SampleShare& share) { return s + share.share; });
    EXPECT_NEAR(sum, 1.0f, 1e-5f);
  }
}

/// Weights (1 - q^2)^2 of two samples, by hand.
TEST(SkinSide, NearerSamplesHaveLargerShares) {
  Skin samples;
  samples.position = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.002f}};
  samples.normal.assign(2, Eigen::Vector3f::UnitZ());
  samples.velocity.assign(2, Eigen::Vector3f::Zero());
  const Eigen::Vector3f x(0.0f, 0.0f, 0.003f);
  const std::vector<NearSample> near = within(samples, x, radius);
  std::vector<SampleShare> shares;
  const SkinPlane plane = planeOf(samples, near, x, radius, dt, shares);
  const auto weight = [](float d) { return std::pow(1.0f - d * d / (radius * radius), 2.0f); };
  const float far = weight(0.003f), close = weight(0.001f);
  EXPECT_NEAR(shares[0].share, far / (far + close), 1e-5f);
  EXPECT_NEAR(shares[1].share, close / (far + close), 1e-5f);
  EXPECT_NEAR(plane.distance, (far * 0.003f + close * 0.001f) / (far + close), 1e-7f);
}

}  // namespace
}  // namespace tactile_clay::clay::skin_side_test
