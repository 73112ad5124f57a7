#include "hand/skin_template.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "hand/anatomy.h"
#include "hand/kinematic_hand.h"

namespace tactile_clay::hand::skin_template_test {
namespace {

constexpr double spacing = 5e-3;  // m

TEST(SkinTemplate, MeanSampleCoversASpacingSquared) {
  const SkinTemplate skin = makeSkinTemplate(Side::right, 1.05, spacing);
  double area = 0.0;
  for (std::size_t i = 0; i < skin.bare_at_rest; ++i) area += skin.samples[i].area;
  RecordProperty("samples", static_cast<int>(skin.samples.size()));
  RecordProperty("bare_at_rest", static_cast<int>(skin.bare_at_rest));
  EXPECT_NEAR(area / static_cast<double>(skin.bare_at_rest) / (spacing * spacing), 1.0, 0.1);
  // The soft hand's literature gives 425 cm^2 for a hand.
  EXPECT_NEAR(area, 0.0425, 0.1 * 0.0425);
}

// On the pads of a soft hand a sample stands for 0.16 of the area of other samples; the total skin is the
// same.
TEST(SkinTemplate, SoftFingersHaveFinePads) {
  const SkinTemplate soft = makeSkinTemplate(Side::right, 1.05, spacing, SkinKind::soft),
                     kinematic = makeSkinTemplate(Side::right, 1.05, spacing);
  double area = 0.0, kinematic_area = 0.0;
  for (std::size_t i = 0; i < kinematic.bare_at_rest; ++i) kinematic_area += kinematic.samples[i].area;
  std::array<double, finger_count> pad_area{};
  std::array<int, finger_count> pad_samples{};
  for (const BoundSample& sample : soft.samples) {
    area += sample.area;
    if (sample.pad_distance > 5e-3F) continue;
    const Joint tip = bones[sample.bone].to;
    for (int finger = 0; finger < finger_count; ++finger)
      if (tip == fingers[finger].tip()) {
        pad_area[finger] += sample.area;
        ++pad_samples[finger];
      }
  }
  EXPECT_EQ(soft.bare_at_rest, soft.samples.size());
  EXPECT_NEAR(area / kinematic_area, 1.0, 0.01);
  for (int finger = 0; finger < finger_count; ++finger) {
    ASSERT_GT(pad_samples[finger], 10) << finger;
    EXPECT_NEAR(pad_area[finger] / pad_samples[finger] / (0.16 * spacing * spacing), 1.0, 0.25) << finger;
  }
}

TEST(SkinTemplate, RejectsASpacingItCannotSample) {
  EXPECT_THROW(makeSkinTemplate(Side::right, 1.0, 0.0), std::invalid_argument);
  EXPECT_THROW(makeSkinTemplate(Side::right, 1.0, std::nan("")), std::invalid_argument);
  EXPECT_THROW(KinematicHands(0.1), std::invalid_argument);
}

TEST(SkinTemplate, EverySpacingIsConnectedAndPositive) {
  for (const double each : {6e-3, 12e-3, 20e-3}) {
    const SkinTemplate skin = makeSkinTemplate(Side::left, 1.0, each);
    for (const BoundSample& sample : skin.samples) {
      EXPECT_TRUE(std::isfinite(sample.pad_distance));
      EXPECT_GT(sample.area, 0.0F);
    }
  }
}

}  // namespace
}  // namespace tactile_clay::hand::skin_template_test
