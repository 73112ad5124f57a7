// What a node keeps of /tf. Needs a master: with_master.py.
#include "nodes/transforms.h"

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <string>
#include <vector>

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration pause(0.01), patience(10.0);

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x) {
  return transformMessage(parent, child, Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, 0.0)),
                          ros::Time(1, 0));
}

class TransformsTest : public testing::Test {
 protected:
  void SetUp() override {
    const ros::WallTime end = ros::WallTime::now() + patience;
    while (sender_.getNumSubscribers() == 0 && ros::WallTime::now() < end) pause.sleep();
    ASSERT_GT(sender_.getNumSubscribers(), 0u);
  }

  void send(const std::vector<geometry_msgs::TransformStamped>& all) {
    tf2_msgs::TFMessage message;
    message.transforms = all;
    sender_.publish(message);
  }
  /// Distance between two frames along x, m; nothing if it is not known.
  std::optional<double> between(const std::string& parent, const std::string& child) {
    const auto pose = transforms_.lookup(parent, child, ros::WallDuration(0.0));
    return pose ? std::optional(pose->translation().x()) : std::nullopt;
  }
  /// Waits until what was sent before has arrived. Messages of one sender arrive in their order.
  bool arrived() {
    const double x = ++sent_;
    send({transform("world", "mark", x)});
    const ros::WallTime end = ros::WallTime::now() + patience;
    while (between("world", "mark") != x && ros::WallTime::now() < end) pause.sleep();
    return between("world", "mark") == x;
  }

 private:
  ros::Publisher sender_ = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf", 100);
  Transforms transforms_;
  int sent_ = 0;
};

/// tf2 keeps each name for ever: fresh parents of one frame would fill the memory.
TEST_F(TransformsTest, ParentsCountAmongTheFrames) {
  ASSERT_TRUE(arrived());  // world and mark
  for (int message = 0; message < 3; ++message) {
    std::vector<geometry_msgs::TransformStamped> all;
    for (int k = 0; k < 1000; ++k)
      all.push_back(transform("parent_" + std::to_string(1000 * message + k), "child", 1.0));
    send(all);
  }
  ASSERT_TRUE(arrived());  // frames that are known still move
  EXPECT_FALSE(between("parent_2999", "child"));
  EXPECT_EQ(between("parent_996", "child"), 1.0);  // the 1000th name, child among them
  send({transform("parent_7", "child", 2.0)});
  ASSERT_TRUE(arrived());
  EXPECT_EQ(between("parent_7", "child"), 2.0);
}

TEST_F(TransformsTest, SlashesMakeNoOtherFrame) {
  std::vector<geometry_msgs::TransformStamped> all;
  for (int slashes = 0; slashes < 1000; ++slashes)
    all.push_back(transform(std::string(slashes, '/') + "table", "/cup", slashes));
  send(all);
  ASSERT_TRUE(arrived());
  EXPECT_EQ(between("table", "cup"), 999.0);
  EXPECT_EQ(between("//table", "///cup"), 999.0);
}

}  // namespace
}  // namespace tactile_clay::nodes

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "transforms_test");
  const ros::NodeHandle stays;
  return RUN_ALL_TESTS();
}
