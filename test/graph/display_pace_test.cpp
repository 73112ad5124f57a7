#include "nodes/display_pace.h"

#include <gtest/gtest.h>

namespace tactile_clay::nodes {
namespace {

TEST(DisplayPace, WorkTakesAtMostAQuarterOfTheTime) {
  DisplayPace pace;
  const ros::SteadyTime begin(100.0);
  EXPECT_TRUE(pace.isDue(begin));
  pace.worked(begin, begin + ros::WallDuration(0.02));
  EXPECT_FALSE(pace.isDue(begin + ros::WallDuration(0.079)));
  EXPECT_TRUE(pace.isDue(begin + ros::WallDuration(0.081)));
  pace.worked(begin + ros::WallDuration(0.1), begin + ros::WallDuration(0.101));  // a fast one follows
  EXPECT_TRUE(pace.isDue(begin + ros::WallDuration(0.105)));
}

}  // namespace
}  // namespace tactile_clay::nodes
