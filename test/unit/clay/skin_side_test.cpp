#include "clay/contact/skin_side.h"

#include <gtest/gtest.h>

#include <numeric>

#include "clouds.h"
#include "support/setups.h"

namespace tactile_clay::clay {
namespace {

constexpr float spacing = 0.005f, radius = 1.5f * spacing, dt = 1.0f / 240.0f;

std::vector<NearGhost> within(const Ghosts& ghosts, const Eigen::Vector3f& x, float far) {
  std::vector<NearGhost> near;
  for (std::uint32_t g = 0; g < ghosts.size(); ++g) {
    const float square = (x - ghosts.position[g]).squaredNorm();
    if (square < far * far) near.push_back({g, square});
  }
  return near;
}

/// Clay between two fingers: their skins face each other, one spacing apart.
Ghosts twoFingers() {
  const float half = 0.5f * spacing;
  Ghosts ghosts = ghostPlane({0.0, 0.0, -half}, Eigen::Vector3d::UnitZ(), 0.01, 0.002, {0.1, 0.0, 0.0});
  append(ghosts, ghostPlane({0.0, 0.0, half}, -Eigen::Vector3d::UnitZ(), 0.01, 0.002, {0.0, 0.2, 0.0}));
  return ghosts;
}

TEST(SkinSide, TheNearestComesFirstAndEachGhostIsOfOneSide) {
  const Ghosts ghosts = twoFingers();
  const Eigen::Vector3f x(0.0003f, 0.0004f, 0.1f * spacing);  // nearer to the upper finger
  std::vector<NearGhost> rest = within(ghosts, x, radius), upper, lower;
  const std::size_t all = rest.size();
  takeSide(ghosts, rest, upper);
  takeSide(ghosts, rest, lower);
  EXPECT_TRUE(rest.empty());
  EXPECT_EQ(upper.size() + lower.size(), all);
  ASSERT_GT(upper.size(), 5u);
  ASSERT_GT(lower.size(), 5u);
  for (const NearGhost& g : upper) EXPECT_LT(ghosts.normal[g.ghost].z(), 0.0f);
  for (const NearGhost& g : lower) EXPECT_GT(ghosts.normal[g.ghost].z(), 0.0f);
}

TEST(SkinSide, GhostsOfACurvedSkinWithinTheAngleAreOneSide) {
  Ghosts ghosts;
  // cosine to the first: within `same_side` and beyond it
  for (const float cosine : {1.0f, 0.5f, Contact::same_side + 0.01f, Contact::same_side - 0.01f, -1.0f}) {
    ghosts.position.emplace_back(0.001f * static_cast<float>(ghosts.size()), 0.0f, 0.0f);
    ghosts.normal.emplace_back(std::sqrt(1.0f - cosine * cosine), 0.0f, cosine);
    ghosts.velocity.emplace_back(0.0f, 0.0f, 0.0f);
  }
  std::vector<NearGhost> rest = within(ghosts, Eigen::Vector3f::Zero(), 1.0f), side;
  takeSide(ghosts, rest, side);
  EXPECT_EQ(side.size(), 3u);
  EXPECT_EQ(rest.size(), 2u);
}

/// The mean of planes that are one is that plane, whatever the weights.
TEST(SkinSide, ThePlaneOfAFlatSkinIsExact) {
  std::mt19937 random(4);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d normal = randomVector(random, 1.0f).normalized().cast<double>();
    const Eigen::Vector3d velocity = randomVector(random, 0.5f).cast<double>();
    const Ghosts ghosts = ghostPlane(Eigen::Vector3d::Zero(), normal, 0.015, 0.002, velocity);
    const Eigen::Vector3f x = randomVector(random, 0.5f * spacing);
    const std::vector<NearGhost> near = within(ghosts, x, radius);
    ASSERT_GT(near.size(), 5u);
    std::vector<GhostShare> shares = {{7, 0.25f}};  // of another contact
    const SkinPlane plane = planeOf(ghosts, near, x, radius, dt, shares);
    const float distance = static_cast<float>(normal.dot(x.cast<double>()));
    EXPECT_NEAR((plane.normal.cast<double>() - normal).norm(), 0.0, 1e-5);
    EXPECT_NEAR(plane.distance, distance, 1e-7f);
    EXPECT_NEAR(plane.before, distance + dt * static_cast<float>(normal.dot(velocity)), 1e-7f);
    EXPECT_NEAR((plane.drift - dt * velocity.cast<float>()).norm(), 0.0f, 1e-7f);
    ASSERT_EQ(shares.size(), near.size() + 1);
    EXPECT_EQ(shares[0].share, 0.25f);
    const float sum = std::accumulate(shares.begin() + 1, shares.end(), 0.0f,
                                      [](float s, const GhostShare& share) { return s + share.share; });
    EXPECT_NEAR(sum, 1.0f, 1e-5f);
  }
}

/// Weights (1 - q^2)^2 of two ghosts, by hand.
TEST(SkinSide, NearerGhostsHaveLargerShares) {
  Ghosts ghosts;
  ghosts.position = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.002f}};
  ghosts.normal.assign(2, Eigen::Vector3f::UnitZ());
  ghosts.velocity.assign(2, Eigen::Vector3f::Zero());
  const Eigen::Vector3f x(0.0f, 0.0f, 0.003f);
  const std::vector<NearGhost> near = within(ghosts, x, radius);
  std::vector<GhostShare> shares;
  const SkinPlane plane = planeOf(ghosts, near, x, radius, dt, shares);
  const auto weight = [](float d) { return std::pow(1.0f - d * d / (radius * radius), 2.0f); };
  const float far = weight(0.003f), close = weight(0.001f);
  EXPECT_NEAR(shares[0].share, far / (far + close), 1e-5f);
  EXPECT_NEAR(shares[1].share, close / (far + close), 1e-5f);
  EXPECT_NEAR(plane.distance, (far * 0.003f + close * 0.001f) / (far + close), 1e-7f);
}

}  // namespace
}  // namespace tactile_clay::clay
