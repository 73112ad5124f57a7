#include "scene/solids.h"

#include <gtest/gtest.h>

#include "scene/robot_model.h"
#include "support/error_of.h"

namespace tactile_clay::scene::solids_test {
namespace {

const std::string share = TACTILE_CLAY_SHARE;

Solids solidsOf(const std::string& name) {
  const Scene scene = loadScene(name, share);
  return Solids(loadRobotModel(scene.urdf), scene.motions);
}

TEST(Solids, TheTableTopIsTheGroundOfTheWorld) {
  const auto solids = solidsOf("kindergarten").at(0.0);
  ASSERT_EQ(solids.size(), 1u);
  EXPECT_NEAR(clay::surface(solids[0], solids[0].pose.inverse() * Eigen::Vector3d(0.1, -0.1, 0.02)).distance,
              0.02, 1e-12);
}

TEST(Solids, TheWheelTurnsAtItsSpeed) {
  const Solids solids = solidsOf("potters_wheel");
  EXPECT_NEAR(solids.joints(0.25).at("wheel_joint"), M_PI / 2, 1e-6);
  const auto at = solids.at(0.25);
  const auto wheel =
      std::find_if(at.begin(), at.end(), [](const clay::Solid& s) { return s.name == "wheel"; });
  ASSERT_NE(wheel, at.end());
  EXPECT_TRUE((wheel->pose.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-6));
}

TEST(Solids, TheirMotionIsThatOfTheScene) {
  const Solids solids = solidsOf("press");
  ASSERT_EQ(solids.solids().front().name, "plate");
  const double high = solids.solids().front().pose.translation().z();
  const auto heightAt = [&](double t) {
    std::vector<Eigen::Isometry3d> poses{5};  // what is there is replaced
    solids.motion()(t, poses);
    EXPECT_EQ(poses.size(), solids.solids().size());
    EXPECT_EQ(poses.front().matrix(), solids.at(t).front().pose.matrix());
    return poses.front().translation().z();
  };
  EXPECT_EQ(heightAt(0.4), high);  // before its start
  EXPECT_NEAR(heightAt(0.6), high - 0.01, 1e-12);
  EXPECT_NEAR(heightAt(0.67), high - 0.017, 1e-12);  // its end
  EXPECT_NEAR(heightAt(1.0), high - 0.017, 1e-12);
}

TEST(Solids, BadModelsAndMotionsAreNamed) {
  EXPECT_THROW(Solids("<robot", {}), std::runtime_error);
  Motion unknown;
  unknown.joint = "tail_joint";
  EXPECT_THROW(Solids(readText(share + "/config/urdf/table.urdf"), {unknown}), std::runtime_error);
  Motion fixed;
  fixed.joint = "table_joint";
  EXPECT_THROW(Solids(readText(share + "/config/urdf/table.urdf"), {fixed}), std::runtime_error);
  EXPECT_THROW(
      Solids("<robot name='r'><link name='world'><collision><geometry><mesh filename='a.stl'/></geometry>"
             "</collision></link></robot>",
             {}),
      std::runtime_error);
}

/// A wheel of this collision shape, on a joint of this axis.
std::string wheel(const std::string& shape, const std::string& axis) {
  return "<robot name='r'><link name='world'/><joint name='j' type='continuous'><parent link='world'/>"
         "<child link='wheel'/><axis xyz='" +
         axis + "'/></joint><link name='wheel'><collision><geometry><" + shape +
         "/></geometry></collision></link></robot>";
}

std::string complaint(const std::string& urdf) {
  Motion turning;
  turning.joint = "j";
  turning.velocity = M_PI;
  return errorOf([&] { Solids(urdf, {turning}); });
}

TEST(Solids, WhatUrdfdomLeavesOutIsAnError) {
  // It tells so on the console only, and the clay would fall through.
  EXPECT_EQ(complaint(wheel("sphere radius='0.1'", "0 0 1")), "");
  EXPECT_NE(complaint(wheel("box size='nan 1 1'", "0 0 1")).find("urdf: the robot model cannot be read"),
            std::string::npos);
  EXPECT_NE(complaint(wheel("ball radius='0.1'", "0 0 1")).find("Unknown geometry type 'ball'"),
            std::string::npos);
  EXPECT_NE(
      complaint(wheel("sphere radius='-0.1'", "0 0 1")).find("link 'wheel' has a collision without size"),
      std::string::npos);
  const std::string no_axis = wheel("sphere radius='0.1'", "0 0 0");
  EXPECT_NE(complaint(no_axis).find("joint 'j' has no axis"), std::string::npos);
  // Its limits may turn it also if nothing moves it.
  EXPECT_EQ(errorOf([&] { Solids(no_axis, {}); }), complaint(no_axis));
}

TEST(Solids, TheLengthOfAnAxisDoesNotMatter) {
  Motion turning;
  turning.joint = "j";
  turning.velocity = M_PI;
  turning.duration = 1.0;
  const Solids solids(wheel("sphere radius='0.1'", "0 0 3"), {turning});
  const clay::Solid solid = solids.at(0.5).front();
  EXPECT_TRUE((solid.pose.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

}  // namespace
}  // namespace tactile_clay::scene::solids_test
