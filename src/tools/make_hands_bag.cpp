// Writes scripted hands into a bag on topic hands/tracked, in frame world, 60 frames a second:
//
//   make_hands_bag knead|press_finger|flat_press|potter FILE.bag
//
// The same arguments write the same hands. The bags of test/bags come from here.
#include <ros/time.h>
#include <rosbag/bag.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <string>

#include "hand/choreography.h"
#include "nodes/conversions.h"

namespace {

namespace hand = tactile_clay::hand;

const std::map<std::string, std::function<hand::Score()>> scores = {
    {"knead", [] { return hand::knead(); }},
    {"press_finger", [] { return hand::pressFinger(); }},
    {"flat_press", [] { return hand::flatPress(); }},
    {"potter", [] { return hand::potter(); }}};

void write(const hand::Score& score, const std::string& file) {
  constexpr int rate = 60;          // Hz
  const ros::Time start(1'000, 0);  // a clock of its own, as a tracker's
  rosbag::Bag bag(file, rosbag::bagmode::Write);
  bag.setCompression(rosbag::compression::BZ2);
  const int last = static_cast<int>(score.duration() * rate);
  for (int i = 0; i <= last; ++i) {
    tactile_clay::TrackedHands message = tactile_clay::nodes::toMessage(score.sample(static_cast<double>(i) / rate));
    message.header.stamp = start + ros::Duration(i / rate, i % rate * (1'000'000'000 / rate));
    message.header.frame_id = "world";
    bag.write("/hands/tracked", message.header.stamp, message);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 || scores.count(argv[1]) == 0) {
    std::fprintf(stderr, "usage: make_hands_bag knead|press_finger|flat_press|potter FILE.bag\n");
    return 2;
  }
  try {
    write(scores.at(argv[1])(), argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_hands_bag: %s\n", error.what());
    return 1;
  }
}
