#include "nodes/skin_queue.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <thread>

namespace tactile_clay::nodes {
namespace {

SkinQueue::Cloud skin(unsigned number) {
  const auto cloud = boost::make_shared<sensor_msgs::PointCloud2>();
  cloud->header.seq = number;
  return cloud;
}

std::vector<unsigned> numbers(const std::vector<SkinQueue::Cloud>& skins) {
  std::vector<unsigned> all;
  for (const SkinQueue::Cloud& skin : skins) all.push_back(skin->header.seq);
  return all;
}

TEST(SkinQueue, LiveAllThatCameMakeOneFrame) {
  SkinQueue queue(false);
  for (const unsigned number : {1U, 2U, 3U}) queue.push(skin(number));
  std::vector<SkinQueue::Cloud> skins;
  ASSERT_TRUE(queue.wait(SkinQueue::Clock::now(), skins));
  EXPECT_EQ(numbers(skins), (std::vector<unsigned>{1, 2, 3}));
  EXPECT_EQ(queue.overtaken(), 2U);
  ASSERT_TRUE(queue.wait(SkinQueue::Clock::now(), skins));
  EXPECT_TRUE(skins.empty());
}

TEST(SkinQueue, LiveTheOldestOfManyLeaves) {
  SkinQueue queue(false);
  for (unsigned number = 0; number < 1000; ++number) queue.push(skin(number));
  std::vector<SkinQueue::Cloud> skins;
  ASSERT_TRUE(queue.wait(SkinQueue::Clock::now(), skins));
  EXPECT_EQ(skins.size(), 64U);
  EXPECT_EQ(skins.back()->header.seq, 999U);
}

TEST(SkinQueue, InLockstepEachIsAFrame) {
  SkinQueue queue(true);
  std::thread sender([&] {
    for (const unsigned number : {1U, 2U, 3U}) queue.push(skin(number));
  });
  for (const unsigned number : {1U, 2U, 3U}) {
    std::vector<SkinQueue::Cloud> skins;
    ASSERT_TRUE(queue.wait({}, skins));  // as long as it takes
    EXPECT_EQ(numbers(skins), std::vector<unsigned>{number});
  }
  sender.join();
  EXPECT_EQ(queue.overtaken(), 0U);
}

TEST(SkinQueue, AStopEndsAllWaiting) {
  SkinQueue queue(true);
  std::thread stopper([&] { queue.stop(); });
  std::vector<SkinQueue::Cloud> skins;
  EXPECT_FALSE(queue.wait({}, skins));
  stopper.join();
}

}  // namespace
}  // namespace tactile_clay::nodes
