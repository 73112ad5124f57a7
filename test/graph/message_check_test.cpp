#include "nodes/message_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "nodes/cloud.h"
#include "nodes/cloud_join.h"
#include "nodes/conversions.h"
#include "nodes/joint_relay.h"
#include "nodes/throttle.h"
#include "nodes/transforms.h"
#include "support/error_of.h"

namespace tactile_clay::nodes {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr std::uint32_t highest = std::numeric_limits<std::uint32_t>::max();

/// A time as it comes in a message: without the normalisation by a constructor.
ros::Time raw(std::uint32_t sec, std::uint32_t nsec) {
  ros::Time time;
  time.sec = sec;
  time.nsec = nsec;
  return time;
}

TEST(Stamps, AllThatAMessageMayHoldCanBeReckonedWith) {
  const std::vector<ros::Time> stamps = {raw(0, 0),
                                         raw(0, highest),
                                         raw(highest, 0),
                                         raw(highest, highest),
                                         raw(1u << 31, 0),
                                         raw(12, 345),
                                         raw((1u << 31) - 1, 999'999'999)};
  for (const ros::Time& from : stamps)
    for (const ros::Time& to : stamps) {
      const double between = secondsBetween(from, to);
      EXPECT_TRUE(std::isfinite(between));
      EXPECT_EQ(between, -secondsBetween(to, from));
      EXPECT_EQ(toCore(toRos(toCore(from))), toCore(from));
    }
  EXPECT_EQ(toCore(raw(12, 345)), seconds(12) + nanoseconds(345));
  EXPECT_DOUBLE_EQ(secondsBetween(raw(10, 500'000'000), raw(12, 0)), 1.5);
  EXPECT_EQ(toRos(nanoseconds(-1)), ros::Time());
  EXPECT_EQ(toRos(nanoseconds::max()).sec, (1u << 31) - 1);
}

TEST(Stamps, ThoseBeyondTheEndAreRefused) {
  EXPECT_EQ(faultOf(raw(0, 0)), "");
  EXPECT_EQ(faultOf(raw((1u << 31) - 1, 999'999'999)), "");
  EXPECT_NE(faultOf(raw(1u << 31, 0)).find("expected less than 2^31 s"), std::string::npos);
  EXPECT_NE(faultOf(raw(5, 1'000'000'000)).find("expected fewer than 10^9"), std::string::npos);
}

TEST(Stamps, OfTheFuture) {
  EXPECT_FALSE(isOfTheFuture(raw(100, 0), raw(100, 0)));
  EXPECT_FALSE(isOfTheFuture(raw(0, 0), raw(100, 0)));
  EXPECT_FALSE(isOfTheFuture(raw(highest, 0), raw(0, 0)));
  EXPECT_TRUE(isOfTheFuture(raw(102, 0), raw(100, 0)));
  EXPECT_TRUE(isOfTheFuture(raw(highest, highest), raw(100, 0)));
}

TEST(MessageCheck, SaysWhatIsTooMuch) {
  TrackedHands hands;
  hands.header.frame_id = "world";
  hands.hands.resize(max_hands);
  EXPECT_EQ(faultOf(hands), "");
  hands.header.stamp = raw(highest, highest);
  EXPECT_NE(faultOf(hands), "");
  hands.header.stamp = {};
  hands.header.frame_id.assign(max_frame_id + 1, 'x');
  EXPECT_NE(faultOf(hands).find("257 characters"), std::string::npos);
  hands.header.frame_id = "world";
  hands.hands.resize(max_hands + 1);
  EXPECT_NE(faultOf(hands).find("65 hands, expected at most 64"), std::string::npos);

  sensor_msgs::PointCloud2 cloud;
  EXPECT_EQ(faultOf(cloud), "");
  cloud.width = cloud.height = highest;
  EXPECT_NE(faultOf(cloud).find("points"), std::string::npos);
  cloud.width = cloud.height = 1;
  cloud.data.resize(max_cloud_bytes + 1);
  EXPECT_NE(faultOf(cloud).find("bytes"), std::string::npos);
  cloud.data.clear();
  cloud.fields.resize(max_cloud_fields + 1);
  EXPECT_NE(faultOf(cloud).find("fields"), std::string::npos);

  FocalPointArray points;
  EXPECT_EQ(faultOf(points), "");
  points.points.resize(2000);  // samples of a field, as many as the renderer makes at most
  EXPECT_EQ(faultOf(points), "");
  points.points.resize(max_focal_points + 1);
  EXPECT_NE(faultOf(points).find("focal points"), std::string::npos);
  points.points.clear();
  points.header.stamp = raw(1u << 31, 0);
  EXPECT_NE(faultOf(points), "");
}

/// Clouds whose sizes contradict each other are refused before a byte is read.
TEST(MessageCheck, CloudsThatContradictThemselvesAreRefused) {
  CloudWriter writer({}, "x y z fx fy fz index:u", 4);
  for (int i = 0; i < 4; ++i) writer << 1.0f << 2.0f << 3.0f << 4.0f << 5.0f << 6.0f << std::uint32_t{7};
  const sensor_msgs::PointCloud2 good = *writer.finish();
  ASSERT_EQ(contactForces(good).size(), 4u);
  const auto refused = [](const sensor_msgs::PointCloud2& cloud) {
    try {
      contactForces(cloud);
    } catch (const std::runtime_error&) {
      return true;
    }
    return false;
  };
  sensor_msgs::PointCloud2 rows = good;
  rows.width = rows.height = 2;
  rows.row_step = 2 * rows.point_step;
  EXPECT_EQ(contactForces(rows).size(), 4u);
  using Change = void (*)(sensor_msgs::PointCloud2&);
  const std::vector<std::pair<const char*, Change>> changes = {
      {"fewer bytes", [](auto& c) { c.data.pop_back(); }},
      {"no bytes", [](auto& c) { c.data.clear(); }},
      {"more points", [](auto& c) { c.width = 5; }},
      {"no step", [](auto& c) { c.point_step = 0; }},
      {"a short step", [](auto& c) { c.point_step = 27; }},
      {"a long step", [](auto& c) { c.point_step = highest; }},
      {"a product that wraps around",
       [](auto& c) {
         c.width = c.height = 1u << 31;
         c.point_step = 28;
       }},
      {"rows with gaps",
       [](auto& c) {
         c.width = c.height = 2;
         c.row_step = 64;
       }},
      {"the other end first", [](auto& c) { c.is_bigendian = true; }},
      {"a field beyond the step", [](auto& c) { c.fields[3].offset = 26; }},
      {"an offset that wraps around", [](auto& c) { c.fields[3].offset = highest - 1; }},
      {"another type", [](auto& c) { c.fields[4].datatype = sensor_msgs::PointField::FLOAT64; }},
      {"no fields", [](auto& c) { c.fields.clear(); }}};
  for (const auto& [what, change] : changes) {
    sensor_msgs::PointCloud2 bad = good;
    change(bad);
    EXPECT_TRUE(refused(bad)) << what;
  }
}

sensor_msgs::PointCloud2Ptr stamped(const ros::Time& stamp, std::size_t bytes = 0) {
  auto cloud = boost::make_shared<sensor_msgs::PointCloud2>();
  cloud->header.stamp = stamp;
  cloud->data.resize(bytes);
  return cloud;
}

TEST(CloudJoin, JoinsWhicheverComesFirst) {
  CloudJoin join;
  EXPECT_FALSE(join.addSkin(stamped({1, 0})));
  const auto pair = join.addContacts(stamped({1, 0}));
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->first->header.stamp, pair->second->header.stamp);
  EXPECT_FALSE(join.addContacts(stamped({2, 0})));
  EXPECT_TRUE(join.addSkin(stamped({2, 0})));
  EXPECT_FALSE(join.addContacts(stamped({1, 0})));  // forgotten
}

/// A join that keeps the latest stamps would drop everything from now on.
TEST(CloudJoin, StampsOfTheFutureDoNotStopIt) {
  CloudJoin join;
  for (std::uint32_t i = 0; i < 1000; ++i) join.addSkin(stamped({2'000'000'000 + i, 0}));
  for (std::uint32_t i = 1; i < 10; ++i) {
    EXPECT_FALSE(join.addSkin(stamped({i, 0})));
    EXPECT_TRUE(join.addContacts(stamped({i, 0})));
  }
}

TEST(CloudJoin, KeepsNoMoreThanItsBytes) {
  CloudJoin join;
  const auto first = stamped({1, 0}, 1u << 20u);
  join.addSkin(first);
  for (std::uint32_t i = 2; i < 70; ++i) join.addSkin(stamped({i, 0}, 1u << 20u));
  EXPECT_EQ(first.use_count(), 1);
}

geometry_msgs::TransformStamped transform() {
  return transformMessage("world", "tracker", Eigen::Isometry3d::Identity(), ros::Time(1, 0));
}

TEST(TransformCheck, SaysWhatIsWrong) {
  EXPECT_EQ(faultOf(transform()), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto bad = transform();
  bad.transform.translation.x = nan;
  EXPECT_NE(faultOf(bad).find("'tracker' at a position that is not finite"), std::string::npos);
  bad = transform();
  bad.transform.rotation.w = nan;
  EXPECT_NE(faultOf(bad).find("unit quaternion"), std::string::npos);
  bad = transform();
  bad.transform.rotation.w = 0.5;
  EXPECT_NE(faultOf(bad).find("unit quaternion"), std::string::npos);
  for (const char* name : {"", "/", "world", "/world"}) {
    bad = transform();
    bad.child_frame_id = name;
    EXPECT_NE(faultOf(bad).find("names of two frames"), std::string::npos) << name;
  }
}

sensor_msgs::JointState jointsOfTwoRobots() {
  sensor_msgs::JointState state;
  state.header.stamp = raw(1, 0);
  state.name = {"elbow", "wheel", "wrist", "plate"};
  state.position = {1.0, 2.0, 3.0, 4.0};
  state.velocity = {5.0, 6.0, 7.0, 8.0};
  state.effort = {9.0};  // not one for each joint
  return state;
}

/// robot_state_publisher keeps every name for ever.
TEST(JointCheck, OnlyJointsOfTheModelPass) {
  sensor_msgs::JointState state = jointsOfTwoRobots();
  state.position[0] = std::numeric_limits<double>::quiet_NaN();  // of a joint that is left out
  const auto passed = ofJoints(state, {"plate", "wheel", "lid"}, raw(1, 0));
  EXPECT_EQ(passed.header.stamp, state.header.stamp);
  EXPECT_EQ(passed.name, (std::vector<std::string>{"wheel", "plate"}));
  EXPECT_EQ(passed.position, (std::vector<double>{2.0, 4.0}));
  EXPECT_EQ(passed.velocity, (std::vector<double>{6.0, 8.0}));
  EXPECT_TRUE(passed.effort.empty());
  EXPECT_TRUE(ofJoints(state, {"knee"}, raw(1, 0)).name.empty());
}

TEST(JointCheck, SaysWhatIsWrong) {
  const std::set<std::string> joints = {"plate", "wheel"};
  const auto fault = [&](void (*change)(sensor_msgs::JointState&)) {
    sensor_msgs::JointState state = jointsOfTwoRobots();
    change(state);
    return errorOf([&] { ofJoints(state, joints, raw(1, 0)); });
  };
  EXPECT_EQ(fault([](auto&) {}), "");
  EXPECT_NE(fault([](auto& s) { s.position[3] = INFINITY; }).find("'plate' at a position that is not finite"),
            std::string::npos);
  EXPECT_NE(fault([](auto& s) { s.position.pop_back(); }).find("4 joints with 3 positions"),
            std::string::npos);
  EXPECT_NE(fault([](auto& s) { s.header.stamp = raw(highest, 0); }).find("stamp in the future"),
            std::string::npos);
}

TEST(Throttle, CountsWhatItHoldsBack) {
  Throttle throttle(1e6), open(0.0);
  EXPECT_EQ(throttle.pass(), 0u);
  EXPECT_EQ(throttle.pass(), std::nullopt);
  EXPECT_EQ(open.pass(), 0u);
  EXPECT_EQ(open.pass(), 0u);
}

}  // namespace
}  // namespace tactile_clay::nodes
