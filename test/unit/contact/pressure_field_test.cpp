#include "contact/pressure_field.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace tactile_clay::contact::pressure_field_test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float inf = std::numeric_limits<float>::infinity();
const Eigen::Vector3f array_below(0.0f, 0.0f, -0.2f);

/// Four samples 5 mm apart; 0 to 2 face down, towards the array, 3 faces up.
class PressureField : public ::testing::Test {
 protected:
  Skin skin;
  std::size_t dropped = 99;

  PressureField() {
    skin.position = {{0, 0, 0}, {0.005f, 0, 0}, {0.010f, 0, 0}, {0.015f, 0, 0}};
    skin.normal = {{0, 0, -1}, {0, 0, -1}, {0.6f, 0, -0.8f}, {0, 0, 1}};
    skin.area = {2.5e-5f, 5.0e-5f, 2.5e-5f, 2.5e-5f};
    skin.weight = {1.0f, 0.9f, 0.8f, 0.7f};
  }

  std::vector<PressureSample> field(const std::vector<SkinForce>& contacts) {
    return pressureField(skin, contacts, array_below, &dropped);
  }
};

TEST_F(PressureField, IsTheNormalForceOverTheArea) {
  // -n . f = -(0.6 * 1 - 0.8 * 2) = 1.0 N for the tilted sample: its tangential part does not press.
  const auto samples = field({{1, {0.3f, 0.4f, 0.1f}}, {2, {1.0f, 5.0f, 2.0f}}});
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].position, skin.position[1]);
  EXPECT_FLOAT_EQ(samples[0].force, 0.1f);
  EXPECT_FLOAT_EQ(samples[0].pressure, 0.1f / 5.0e-5f);
  EXPECT_FLOAT_EQ(samples[0].area, 5.0e-5f);
  EXPECT_FLOAT_EQ(samples[0].weight, 0.9f);
  EXPECT_FLOAT_EQ(samples[1].force, 1.0f);
  EXPECT_FLOAT_EQ(samples[1].pressure, 1.0f / 2.5e-5f);
  EXPECT_EQ(samples[1].normal, skin.normal[2]);
  EXPECT_EQ(dropped, 0u);
}

TEST_F(PressureField, SlipOfASampleIsTheMeanByForce) {
  // 0.3 N at 0.01 m/s and 0.1 N at 0.05 m/s.
  const auto samples = field({{1, {0, 0, 0.3f}, 0.01f}, {0, {0, 0, 0.1f}, 0.2f}, {1, {0, 0, 0.1f}, 0.05f}});
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_FLOAT_EQ(samples[0].slip, 0.2f);
  EXPECT_FLOAT_EQ(samples[1].slip, 0.02f);
  EXPECT_TRUE(field({{1, {0, 0, 0.3f}, nan}, {0, {0, 0, 0.1f}, -1.0f}}).empty());
  EXPECT_EQ(dropped, 2u);
}

TEST_F(PressureField, LeavesOutPullAndTangentialForce) {
  EXPECT_TRUE(field({{0, {0, 0, -1.0f}}, {1, {3.0f, 0, 0}}}).empty());
}

TEST_F(PressureField, LeavesOutSkinThatFacesAway) {
  const std::vector<SkinForce> contacts{{3, {0, 0, -1.0f}}};
  EXPECT_TRUE(field(contacts).empty());
  const Eigen::Vector3f array_above(0, 0, 0.2f);
  EXPECT_EQ(pressureField(skin, contacts, array_above).size(), 1u);
}

TEST_F(PressureField, SkinAroundIsTheBareSkinNearContactsThatFacesTheArray) {
  const auto pressed = field({{1, {0, 0, 0.1f}}});
  ASSERT_EQ(pressed.size(), 1u);
  const auto around = skinAround(skin, pressed, array_below, 0.006f);
  ASSERT_EQ(around.size(), 2u) << "the pressed one and the one that faces away are none of it";
  EXPECT_EQ(around[0].position, skin.position[0]);
  EXPECT_EQ(around[1].position, skin.position[2]);
  EXPECT_EQ(around[1].normal, skin.normal[2]);
  EXPECT_EQ(around[1].pressure, 0.0f);
  EXPECT_EQ(around[1].force, 0.0f);
  EXPECT_EQ(around[1].area, skin.area[2]);
  EXPECT_EQ(around[1].weight, skin.weight[2]);
  EXPECT_TRUE(skinAround(skin, pressed, array_below, 0.004f).empty());
  EXPECT_TRUE(skinAround(skin, {}, array_below, 0.06f).empty());
  skin.position[0].x() = nan;
  skin.area[2] = 0.0f;  // covered by other skin
  EXPECT_TRUE(skinAround(skin, pressed, array_below, 0.006f).empty());
  EXPECT_THROW(skinAround(skin, pressed, array_below, nan), std::invalid_argument);
}

TEST_F(PressureField, LeavesOutSkinSeenEdgeOn) {
  const Eigen::Vector3f beside(1.0f, 0, 0);  // n . (array - x) = 0
  EXPECT_TRUE(pressureField(skin, {{0, {0, 0, 1.0f}}}, beside).empty());
}

/// A virtual hand held 0.1 m above the tracked one, which is turned and of other areas.
class FeltElsewhere : public PressureField {
 protected:
  FeltElsewhere() {
    skin.tracked_position = {{0, 0, -0.1f}, {0.005f, 0, -0.1f}, {0.010f, 0, -0.1f}, {0.015f, 0, -0.1f}};
    skin.tracked_normal = {{0, 0.6f, -0.8f}, {0, 0, -1}, {0, 0, 1}, {0, 0, -1}};
    skin.tracked_area = {1e-5f, 2e-5f, 3e-5f, 4e-5f};
  }
};

TEST_F(FeltElsewhere, PressureArisesOnTheSkinAndIsFeltOnTheTrackedHand) {
  const auto samples = field({{0, {0, 0, 0.5f}}, {1, {0.3f, 0.4f, 0.1f}}});
  ASSERT_EQ(samples.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(samples[i].position, skin.tracked_position[i]);
    EXPECT_EQ(samples[i].normal, skin.tracked_normal[i]);
    EXPECT_EQ(samples[i].area, skin.tracked_area[i]);
    EXPECT_EQ(samples[i].weight, skin.weight[i]);
  }
  EXPECT_FLOAT_EQ(samples[0].force, 0.5f);
  EXPECT_FLOAT_EQ(samples[0].pressure, 0.5f / 2.5e-5f);
  EXPECT_FLOAT_EQ(samples[1].pressure, 0.1f / 5.0e-5f);
  EXPECT_EQ(dropped, 0u);
}

TEST_F(FeltElsewhere, TheTrackedSkinIsWhatFacesTheArray) {
  EXPECT_TRUE(field({{2, {0, 0, 1.0f}}}).empty()) << "faces it in the clay, but not where it is felt";
  const auto samples = field({{3, {0, 0, -1.0f}}});
  ASSERT_EQ(samples.size(), 1u) << "faces it where it is felt, but not in the clay";
  EXPECT_FLOAT_EQ(samples[0].force, 1.0f);
  EXPECT_EQ(dropped, 0u);
}

TEST_F(FeltElsewhere, WhatOtherSkinCoversIsNotFelt) {
  skin.tracked_area[0] = 0.0f;
  EXPECT_EQ(field({{0, {0, 0, 1.0f}}, {1, {0, 0, 1.0f}}}).size(), 1u);
  EXPECT_EQ(dropped, 0u) << "no fault";
}

TEST_F(FeltElsewhere, DropsBrokenPlacesAndRefusesTooFew) {
  skin.tracked_position[0].y() = nan;
  skin.tracked_normal[1].z() = inf;
  skin.tracked_area[2] = -1e-5f;
  const Eigen::Vector3f push(0, 0, 1.0f);
  EXPECT_EQ(field({{0, push}, {1, push}, {2, push}, {3, -push}}).size(), 1u);
  EXPECT_EQ(dropped, 3u);
  skin.tracked_normal.pop_back();
  EXPECT_THROW(field({}), std::invalid_argument);
}

TEST_F(PressureField, AddsForcesOnOneSampleAndKeepsSkinOrder) {
  const auto samples = field({{1, {0, 0, 0.2f}}, {0, {0, 0, 0.5f}}, {1, {0, 0, 0.3f}}, {1, {0, 0, -0.1f}}});
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_FLOAT_EQ(samples[0].force, 0.5f);
  EXPECT_EQ(samples[0].position, skin.position[0]);
  EXPECT_FLOAT_EQ(samples[1].force, 0.4f);
}

TEST_F(PressureField, ConservesTheNormalForceOfAFlatContact) {
  // The pressure integrated over the skin is the force that went in.
  skin.normal[2] = {0, 0, -1};
  const auto samples = field({{0, {0, 0, 0.5f}}, {1, {0, 0, 0.7f}}, {2, {0, 0, 0.9f}}});
  double total = 0.0;
  for (const auto& s : samples) total += static_cast<double>(s.pressure) * s.area;
  EXPECT_NEAR(total, 2.1, 1e-6);
}

TEST_F(PressureField, OfNoContactIsEmpty) {
  EXPECT_TRUE(field({}).empty());
  EXPECT_EQ(dropped, 0u);
}

TEST_F(PressureField, DropsNonFiniteForcesAndKeepsTheOthers) {
  const auto samples = field({{0, {0, 0, nan}}, {0, {0, 0, 0.5f}}, {1, {0, inf, 1.0f}}, {2, {0, 0, 1.0f}}});
  EXPECT_EQ(dropped, 2u);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_FLOAT_EQ(samples[0].force, 0.5f);
  EXPECT_FLOAT_EQ(samples[1].force, 0.8f);
}

TEST_F(PressureField, DropsContactsOnBrokenSkin) {
  skin.position[0].x() = nan;
  skin.normal[1].y() = inf;
  skin.area[2] = -1e-5f;
  skin.weight[3] = nan;
  const Eigen::Vector3f push(0, 0, 1.0f);
  EXPECT_TRUE(field({{0, push}, {1, push}, {2, push}, {3, -push}}).empty());
  EXPECT_EQ(dropped, 4u);
}

TEST_F(PressureField, WhatOtherSkinCoversIsNotFelt) {
  const Eigen::Vector3f push(0, 0, 1.0f);
  ASSERT_EQ(field({{0, push}}).size(), 1u);
  skin.area[0] = 0.0f;
  EXPECT_TRUE(field({{0, push}}).empty());
  EXPECT_EQ(dropped, 0u);
}

TEST_F(PressureField, DropsAPressureThatOverflows) {
  skin.area[0] = 1e-30f;
  EXPECT_TRUE(field({{0, {0, 0, 1e30f}}}).empty());
  EXPECT_EQ(dropped, 1u);
}

TEST_F(PressureField, RefusesAnIndexOutsideTheSkin) {
  EXPECT_THROW(field({{4, {0, 0, 1.0f}}}), std::out_of_range);
}

TEST_F(PressureField, RefusesArraysOfUnequalLength) {
  skin.area.pop_back();
  EXPECT_THROW(field({}), std::invalid_argument);
}

TEST_F(PressureField, RefusesAnArrayNowhere) {
  EXPECT_THROW(pressureField(skin, {}, {nan, 0, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::contact::pressure_field_test
