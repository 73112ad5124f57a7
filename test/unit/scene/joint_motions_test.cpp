#include "scene/joint_motions.h"

#include <gtest/gtest.h>

#include <limits>

#include "scene/solids.h"
#include "support/error_of.h"

namespace tactile_clay::scene::joint_motions_test {
namespace {

constexpr double for_ever = std::numeric_limits<double>::infinity();

std::string joint(const std::string& name, const std::string& type, const std::string& inside) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='world'/><child link='of_" + name +
         "'/><axis xyz='1 0 0'/>" + inside + "</joint><link name='of_" + name +
         "'><collision><geometry><sphere radius='0.01'/></geometry></collision></link>";
}
std::string limits(double lower, double upper) {
  return "<limit lower='" + std::to_string(lower) + "' upper='" + std::to_string(upper) +
         "' effort='1' velocity='10'/>";
}
std::string mimic(const std::string& of, double multiplier, double offset) {
  return "<mimic joint='" + of + "' multiplier='" + std::to_string(multiplier) + "' offset='" +
         std::to_string(offset) + "'/>";
}
std::string robot(const std::string& joints) {
  return "<robot name='r'><link name='world'/>" + joints + "</robot>";
}
std::string complaint(const std::string& urdf, const std::vector<Motion>& motions) {
  return errorOf([&] { Solids(urdf, motions); });
}
bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

TEST(JointMotions, FollowOneAnother) {
  const Solids solids(robot(joint("screw", "prismatic", limits(-1.0, 1.0))),
                      // in the order of the file, which is not that of time: lift, press; between them the
                      // joint stands still
                      {{"screw", 0.5, -0.2, 0.1}, {"screw", 0.1, 0.1, 0.2}});
  for (const auto& [t, position] : std::vector<std::pair<double, double>>{{0.0, 0.0},
                                                                          {0.1, 0.0},
                                                                          {0.2, 0.01},
                                                                          {0.3, 0.02},
                                                                          {0.4, 0.02},
                                                                          {0.5, 0.02},
                                                                          {0.55, 0.01},
                                                                          {9.0, 0.0}})
    EXPECT_NEAR(solids.joints(t).at("screw"), position, 1e-12) << t;
  EXPECT_TRUE(solids.remarks().empty());
}

TEST(JointMotions, StopAtLimitsAndGoOnFromThere) {
  const Solids solids(
      robot(joint("screw", "prismatic", limits(-0.001, 0.006))),
      {{"screw", 0.1, 0.03, 0.5}, {"screw", 1.0, -0.01, 0.2}, {"screw", 2.0, -1.0, for_ever}});
  EXPECT_EQ(solids.joints(0.6).at("screw"), 0.006);
  EXPECT_EQ(solids.joints(1.0).at("screw"), 0.006);
  EXPECT_NEAR(solids.joints(1.2).at("screw"), 0.004, 1e-12);  // not 0.013: it was stopped
  EXPECT_EQ(solids.joints(1e9).at("screw"), -0.001);
  ASSERT_EQ(solids.remarks().size(), 2U);
  EXPECT_EQ(solids.remarks()[0], "joint 'screw' stops at 0.006 m after 0.3 s, its upper limit of 0.006 m");
  EXPECT_TRUE(has(solids.remarks()[1], "its lower limit of -0.001 m")) << solids.remarks()[1];
  EXPECT_NEAR(solids.at(0.6).front().pose.translation().x(), 0.006, 1e-12);
}

TEST(JointMotions, OnlyRevoluteAndPrismaticJointsHaveLimits) {
  const std::vector<Motion> turn = {{"wheel", 0.0, 2.0, for_ever}};
  EXPECT_EQ(Solids(robot(joint("wheel", "continuous", limits(0.0, 1.0))), turn).joints(3.0).at("wheel"), 6.0);
  EXPECT_EQ(Solids(robot(joint("wheel", "revolute", limits(0.0, 1.0))), turn).joints(3.0).at("wheel"), 1.0);
}

TEST(JointMotions, AJointWhoseLimitsExcludeZeroStartsAtTheNearest) {
  const Solids solids(robot(joint("lid", "revolute", limits(0.2, 1.0))), {});
  EXPECT_EQ(solids.joints(0.0).at("lid"), 0.2);
  ASSERT_EQ(solids.remarks().size(), 1U);
  EXPECT_TRUE(has(solids.remarks()[0], "joint 'lid' starts at 0.2 rad")) << solids.remarks()[0];
}

TEST(JointMotions, WhatIsFasterThanTheVelocityLimitIsTold) {
  const Solids solids(robot(joint("lid", "revolute", limits(-9.0, 9.0))), {{"lid", 0.0, 12.0, 0.1}});
  ASSERT_EQ(solids.remarks().size(), 1U);
  EXPECT_TRUE(
      has(solids.remarks()[0], "'lid' is moved with 12 rad/s, faster than its velocity limit of 10 rad/s"));
}

TEST(JointMotions, WhatMimicsHasVelocityLimitsOfItsOwn) {
  const auto robotWith = [](double multiplier) {
    return robot(joint("slow", "revolute", limits(-9.0, 9.0)) +
                 joint("quick", "revolute", limits(-99.0, 99.0) + mimic("slow", multiplier, 0.0)));
  };
  const std::vector<Motion> motions = {{"slow", 0.0, 5.0, 0.1}};
  const Solids solids(robotWith(-3.0), motions);
  ASSERT_EQ(solids.remarks().size(), 1U);
  EXPECT_TRUE(
      has(solids.remarks()[0], "'quick' is moved with -15 rad/s, faster than its velocity limit of 10"))
      << solids.remarks()[0];
  EXPECT_TRUE(
      has(complaint(robotWith(1e300), motions), "joint 'quick' is moved with 5e+300 rad/s, expected at most"))
      << complaint(robotWith(1e300), motions);
}

TEST(JointMotions, MimicJointsFollowThroughChains) {
  const std::string chain = robot(joint("c", "continuous", mimic("b", 3.0, 0.5)) +
                                  joint("b", "prismatic", limits(-1.0, 1.0) + mimic("a", -2.0, 0.1)) +
                                  joint("a", "prismatic", limits(-1.0, 1.0)));
  const Solids solids(chain, {{"a", 0.0, 0.1, 2.0}});
  const auto at = solids.joints(1.0);
  EXPECT_NEAR(at.at("a"), 0.1, 1e-12);
  EXPECT_NEAR(at.at("b"), -0.1, 1e-12);
  EXPECT_NEAR(at.at("c"), 0.2, 1e-12);
  for (const clay::Solid& solid : solids.at(1.0)) {
    if (solid.name == "of_b") {
      EXPECT_NEAR(solid.pose.translation().x(), -0.1, 1e-12);
    }
    if (solid.name == "of_c") {
      EXPECT_NEAR(Eigen::AngleAxisd(solid.pose.linear()).angle(), 0.2, 1e-12);
    }
  }
}

/// They are one mechanism, and robot_state_publisher does not check the limits of joints that follow.
TEST(JointMotions, TheLimitOfAFollowerStopsTheMechanism) {
  const Solids solids(robot(joint("screw", "prismatic", limits(-1.0, 1.0)) +
                            joint("jaw", "prismatic", limits(-0.01, 0.5) + mimic("screw", -0.5, 0.0))),
                      {{"screw", 0.0, 0.1, 1.0}});
  EXPECT_NEAR(solids.joints(1.0).at("screw"), 0.02, 1e-12);
  EXPECT_NEAR(solids.joints(1.0).at("jaw"), -0.01, 1e-12);
  ASSERT_EQ(solids.remarks().size(), 1U);
  EXPECT_EQ(
      solids.remarks()[0],
      "joint 'screw' stops at 0.02 m after 0.2 s, where joint 'jaw', which mimics it, has its lower limit of "
      "-0.01 m");
}

TEST(JointMotions, WhatCannotBeIsRefused) {
  const std::string slide = joint("a", "prismatic", limits(-1.0, 1.0));
  const std::string circle =
      robot(joint("a", "continuous", mimic("b", 1.0, 0.0)) + joint("b", "continuous", mimic("a", 1.0, 0.0)));
  EXPECT_TRUE(has(complaint(circle, {}), "mimics joints in a circle")) << complaint(circle, {});
  EXPECT_TRUE(has(complaint(robot(joint("a", "continuous", mimic("a", 1.0, 0.0))), {}), "in a circle"));
  EXPECT_NE(complaint(robot(joint("a", "continuous", mimic("nobody", 1.0, 0.0))), {}), "");
  EXPECT_TRUE(
      has(complaint(robot(slide + joint("b", "continuous", mimic("a", 1.0, 0.0))), {{"b", 0.0, 1.0, 1.0}}),
          "mimics 'a', expected a motion of 'a'"));
  EXPECT_TRUE(
      has(complaint(robot(joint("a", "prismatic", limits(1.0, -1.0))), {}), "expected the lower one first"));
  EXPECT_TRUE(
      has(complaint(robot(slide + joint("b", "prismatic", limits(5.0, 6.0) + mimic("a", 1.0, 0.0))), {}),
          "limits that leave it no position"));
  EXPECT_TRUE(
      has(complaint(robot(slide + joint("b", "prismatic", limits(5.0, 6.0) + mimic("a", 0.0, 0.0))), {}),
          "outside its limits"));
}

/// A mimic of a joint that stands still is at its offset.
TEST(JointMotions, AMimicOfAFixedJointStandsStill) {
  const Solids solids(
      robot(joint("f", "fixed", "") + joint("m", "prismatic", limits(-1.0, 1.0) + mimic("f", 2.0, 0.3))), {});
  EXPECT_EQ(solids.joints(5.0), (std::map<std::string, double>{{"m", 0.3}}));
}

}  // namespace
}  // namespace tactile_clay::scene::joint_motions_test
