#include <gtest/gtest.h>

#include <algorithm>

#include "hand/choreography.h"
#include "played_score.h"

/// What presses a block is what the score is named after, at its place, depth and time.
namespace tactile_clay::hand::press_score_test {
namespace {

using namespace played_score;

TEST(PressScore, TheIndexFingerAloneTouchesTheBlock) {
  PressFinger parameters;
  parameters.centre = {0.03, -0.02};
  parameters.depth = 0.012;
  const Score score = pressFinger(parameters);
  double deepest = 1.0;
  double touched = -1.0;
  double reached = -1.0;
  double left = -1.0;
  play(score, [&](double t, const TrackedFrame& frame, const Skin& skin) {
    const double z = lowest(frame);
    if (t == 0.0) {
      EXPECT_NEAR(z, 0.1, 1e-6);
    }
    deepest = std::min(deepest, z);
    if (touched < 0.0 && z < 0.04 - 1e-4) touched = t;
    if (reached < 0.0 && z < 0.028 + 5e-5) reached = t;
    if (z < 0.028 + 5e-5) left = t;
    for (std::size_t i = 0; i < skin.size(); ++i) {
      if (skin.position[i].z() >= 0.04F) continue;
      EXPECT_EQ(skin.region[i], index_distal);
      EXPECT_LT((skin.position[i].head<2>() - Eigen::Vector2f(0.03F, -0.02F)).norm(), 0.02F);
    }
  });
  EXPECT_NEAR(deepest, 0.028, 1e-6);
  EXPECT_NEAR(reached - touched, 0.4, 3 * frame_time);
  EXPECT_NEAR(left - reached, 0.5, 3 * frame_time);
}

TEST(PressScore, TheThumbAlonePressesTheBlockWithItsPad) {
  const PressFinger parameters;
  double deepest = 1.0;
  float palmar = 0.0F;  // cosine between the skin where it presses, and the palmar side of the thumb's tip
  play(pressThumb(parameters), [&](double, const TrackedFrame& frame, const Skin& skin) {
    const Eigen::Vector3d pad_side =
        -(frame.hands.at(0).joints[thumb_tip].orientation * Eigen::Vector3d::UnitY());
    for (std::size_t i = 0; i < skin.size(); ++i) {
      if (skin.position[i].z() >= 0.04F || skin.position[i].head<2>().cwiseAbs().maxCoeff() > 0.02F) continue;
      EXPECT_EQ(skin.region[i], thumb_distal);
      if (skin.position[i].z() >= deepest) continue;
      deepest = skin.position[i].z();
      palmar = skin.normal[i].dot(pad_side.cast<float>());
    }
  });
  EXPECT_GT(palmar, 0.8F);
  EXPECT_NEAR(deepest, parameters.block_height - parameters.depth, 1.5e-3);
}

TEST(PressScore, TheFlatHandPressesWithPalmToItsDepth) {
  const PressFinger parameters;
  const Score score = flatPress(parameters);
  double deepest = 1.0;
  int maximum = 0;
  play(score, [&](double, const TrackedFrame& /*frame*/, const Skin& skin) {
    int touching = 0;
    for (std::size_t i = 0; i < skin.size(); ++i) {
      if (skin.position[i].head<2>().cwiseAbs().maxCoeff() > 0.019F) continue;
      deepest = std::min<double>(deepest, skin.position[i].z());
      if (skin.position[i].z() < 0.04F) ++touching;
    }
    maximum = std::max(maximum, touching);
  });
  EXPECT_NEAR(deepest, parameters.block_height - parameters.depth, 1.5e-3);
  EXPECT_GT(maximum, 15);  // of 25 samples on 40 x 40 mm
}

}  // namespace
}  // namespace tactile_clay::hand::press_score_test
