#include "nodes/conversions.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "nodes/cloud.h"

namespace tactile_clay::nodes {
namespace {

std_msgs::Header header(const char* frame) {
  std_msgs::Header header;
  header.stamp = ros::Time(12, 345);
  header.frame_id = frame;
  return header;
}

Skin twoSamples() {
  Skin skin;
  skin.position = {{1, 2, 3}, {4, 5, 6}};
  skin.normal = {{0, 0, 1}, {0, 1, 0}};
  skin.velocity = {{7, 8, 9}, {-1, -2, -3}};
  skin.area = {1e-5f, 2e-5f};
  skin.pad_distance = {0.0f, 0.1f};
  skin.side = {0, 1};
  skin.region = {10, 1};
  return skin;
}

TEST(Conversions, TrackedHandsComeBackAsTheyWere) {
  hand::TrackedFrame frame;
  frame.stamp = std::chrono::nanoseconds(12'000'000'345);
  frame.frame_id = "somewhere";
  hand::TrackedHand& hand = frame.hands.emplace_back();
  hand.id = 7;
  hand.side = hand::Side::right;
  hand.confidence = 0.25;
  for (int j = 0; j < hand::joint_count; ++j) {
    hand.joints[static_cast<std::size_t>(j)].position = {0.1 * j, 1.0, -2.0};
    hand.joints[static_cast<std::size_t>(j)].orientation = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
    hand.joints[static_cast<std::size_t>(j)].radius = 0.0078125 * j;
  }
  const hand::TrackedFrame back = toCore(toMessage(frame));
  EXPECT_EQ(back.stamp, frame.stamp);
  EXPECT_EQ(back.frame_id, frame.frame_id);
  ASSERT_EQ(back.hands.size(), 1u);
  EXPECT_EQ(back.hands[0].id, 7u);
  EXPECT_EQ(back.hands[0].side, hand::Side::right);
  EXPECT_EQ(back.hands[0].confidence, 0.25);
  for (std::size_t j = 0; j < hand::joint_count; ++j) {
    EXPECT_EQ(back.hands[0].joints[j].position, hand.joints[j].position);
    EXPECT_EQ(back.hands[0].joints[j].orientation.coeffs(), hand.joints[j].orientation.coeffs());
    EXPECT_EQ(back.hands[0].joints[j].radius, hand.joints[j].radius);
  }
}

// A side that is neither left nor right stays so, so that the check of hands sees it. If it were taken for
// one of the two, it could replace the real hand.
TEST(Conversions, ASideThatIsNeitherIsNotTakenForOne) {
  TrackedHands message;
  message.hands.resize(3);
  for (std::uint8_t side : {0, 1, 2}) message.hands[side].side = side;
  const hand::TrackedFrame frame = toCore(message);
  EXPECT_EQ(frame.hands[0].side, hand::Side::left);
  EXPECT_EQ(frame.hands[1].side, hand::Side::right);
  EXPECT_NE(frame.hands[2].side, hand::Side::left);
  EXPECT_NE(frame.hands[2].side, hand::Side::right);
}

TEST(Conversions, SkinKeepsItsSamplesAndFields) {
  const auto cloud = skinCloud(twoSamples(), header("world"));
  std::string fields;
  for (const auto& field : cloud->fields) fields += field.name + " ";
  EXPECT_EQ(fields, "x y z normal_x normal_y normal_z vx vy vz area hand region weight pad_distance ");
  EXPECT_EQ(cloud->header.frame_id, "world");
  const Skin samples = claySkin(*cloud);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples.position[1], Eigen::Vector3f(4, 5, 6));
  EXPECT_EQ(samples.normal[0], Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(samples.velocity[1], Eigen::Vector3f(-1, -2, -3));
  const Skin skin = pressureSkin(*cloud);
  EXPECT_EQ(skin.area[1], 2e-5f);
  EXPECT_EQ(skin.weight[0], 1.0f);  // on the pad
  EXPECT_LT(skin.weight[1], 0.5f);
  EXPECT_EQ(column<std::uint32_t>(*cloud, "hand")[1], 1u);
  EXPECT_EQ(column<std::uint32_t>(*cloud, "region")[0], 10u);
}

// Skin of a tracked hand, as in old bags, is felt where it is. Skin of a virtual hand is felt on the tracked
// hand.
TEST(Conversions, SkinOfAVirtualHandTellsWhereItIsFelt) {
  EXPECT_TRUE(pressureSkin(*skinCloud(twoSamples(), header("world"))).isTracked());
  Skin skin = twoSamples();
  skin.tracked_position = {{1, 2, 2}, {4, 5, 5}};
  skin.tracked_normal = {{0, 1, 0}, {1, 0, 0}};
  skin.tracked_area = {3e-5f, 0.0f};
  const auto cloud = skinCloud(skin, header("world"));
  EXPECT_EQ(claySkin(*cloud).position[1], Eigen::Vector3f(4, 5, 6)) << "the clay meets the virtual hand";
  const Skin pressed = pressureSkin(*cloud);
  ASSERT_FALSE(pressed.isTracked());
  EXPECT_EQ(pressed.position[1], Eigen::Vector3f(4, 5, 6));
  EXPECT_EQ(pressed.tracked_position, skin.tracked_position);
  EXPECT_EQ(pressed.tracked_normal, skin.tracked_normal);
  EXPECT_EQ(pressed.tracked_area, skin.tracked_area);
}

TEST(Conversions, SkinThatTellsHalfOfWhereItIsFeltIsRefused) {
  CloudWriter writer(header("world"), "x y z normal_x normal_y normal_z area weight tracked_x tracked_y", 0);
  try {
    pressureSkin(*writer.finish());
    FAIL() << "accepted places without a height";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("'tracked_z'"), std::string::npos) << error.what();
  }
}

// If two skins have one stamp, forces of one skin must not press samples of the other.
TEST(Conversions, ContactsAreOnTheSkinThatTheyAreOf) {
  const auto cloud = skinCloud(twoSamples(), header("world"));
  const auto contacts = contactCloud({{1, {0, 0, 1}}}, claySkin(*cloud), *cloud);
  const Skin skin = pressureSkin(*cloud);
  EXPECT_TRUE(onSkin(*contacts, skin));
  EXPECT_TRUE(onSkin(*contactCloud({}, {}, *cloud), Skin()));
  EXPECT_EQ(pointCount(*contactCloud({}, {}, sensor_msgs::PointCloud2())), 0U);  // a skin that was left out
  Skin moved = twoSamples();
  moved.position[1].x() += 0.01f;
  EXPECT_FALSE(onSkin(*contacts, pressureSkin(*skinCloud(moved, header("world")))));
  EXPECT_FALSE(onSkin(*contacts, Skin())) << "a hand that is gone";
  CloudWriter forces_alone(header("world"), "fx fy fz index:u", 1);
  forces_alone << 0.0f << 0.0f << 1.0f << std::uint32_t{1};
  EXPECT_TRUE(onSkin(*forces_alone.finish(), skin));
}

TEST(Conversions, ContactsTellWhoseSkinTheyAreOnAndHowItMoves) {
  Skin skin = twoSamples();
  skin.side[1] = 1;
  skin.region[1] = hand::index_distal;
  const auto cloud = skinCloud(skin, header("world"));
  const auto contacts = contactCloud({{1, {0, 0, 1}, 0.03f}}, claySkin(*cloud), *cloud);
  EXPECT_EQ(contactForces(*contacts)[0].slip, 0.03f);
  EXPECT_EQ(column<std::uint32_t>(*contacts, "hand")[0], 1u);
  EXPECT_EQ(column<std::uint32_t>(*contacts, "region")[0], std::uint32_t{hand::index_distal});
  EXPECT_EQ(column<float>(*contacts, "area")[0], skin.area[1]);
  EXPECT_EQ(column<float>(*contacts, "vz")[0], skin.velocity[1].z());
  CloudWriter others(header("world"), "x y z normal_x normal_y normal_z vx vy vz hand region area", 1);
  for (int k = 0; k < 12; ++k) others << (k == 5 ? 1.0f : 0.5f);
  const auto foreign = others.finish();
  EXPECT_FALSE(hasField(*contactCloud({{0, {0, 0, 1}}}, claySkin(*foreign), *foreign), "hand"))
      << "of another type";
}

TEST(Conversions, FieldsAreFoundByNameWhereverTheyStand) {
  CloudWriter writer(header("array"), "weight area force pressure normal_z normal_y normal_x extra:u z y x",
                     1);
  writer << 0.5f << 1e-5f << 2.0f << 300.0f << 1.0f << 0.0f << 0.0f << std::uint32_t{9} << 3.0f << 2.0f
         << 1.0f;
  const auto samples = pressureSamples(*writer.finish());
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].position, Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(samples[0].pressure, 300.0f);
  EXPECT_EQ(samples[0].weight, 0.5f);
  EXPECT_EQ(samples[0].slip, 0.0f) << "clay of others may not tell it";
  contact::PressureSample sliding = samples[0];
  sliding.slip = 0.04f;
  EXPECT_EQ(pressureSamples(*pressureCloud({sliding}, header("array")))[0].slip, 0.04f);
}

TEST(Conversions, ACloudWithoutAFieldOrWithTooFewBytesIsRefusedByName) {
  CloudWriter writer(header("world"), "x y z", 1);
  writer << 1.0f << 2.0f << 3.0f;
  auto cloud = writer.finish();
  try {
    contactForces(*cloud);
    FAIL() << "accepted contacts without forces";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("'fx'"), std::string::npos) << error.what();
  }
  cloud = skinCloud(twoSamples(), header("world"));
  cloud->data.resize(cloud->data.size() - 1);
  EXPECT_THROW(claySkin(*cloud), std::runtime_error);
}

TEST(Conversions, ASkinThatIsNotFiniteIsRefused) {
  Skin skin = twoSamples();
  skin.velocity[1].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(claySkin(*skinCloud(skin, header("world"))), std::runtime_error);
}

TEST(Conversions, EmptyCloudsKeepTheirFields) {
  const auto cloud = pressureCloud({}, header("array"));
  EXPECT_EQ(cloud->fields.size(), 11u);
  EXPECT_TRUE(pressureSamples(*cloud).empty());
}

}  // namespace
}  // namespace tactile_clay::nodes
