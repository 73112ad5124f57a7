#include <ros/time.h>
#include <rosbag/bag.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>

#include "hand/choreography.h"
#include "nodes/conversions.h"
#include "tools/tool_arguments.h"

namespace {

constexpr char usage[] =
    R"(Writes the bags of test/bags: scripted hands on the topic /hands/tracked, in the coordinate frame `world`, 60
samples per second.

  make_bags FOLDER

The program writes the same messages every time. test/bags/README.md describes each bag.
)";

namespace hand = tactile_clay::hand;
using tactile_clay::TrackedHand;
using tactile_clay::TrackedHands;

constexpr int rate = 60;          // Hz
const ros::Time epoch(1'000, 0);  // the hands' own clock, like that of a tracker
constexpr double sight = 0.3;     // m; a hand whose palm is farther aside than this is not seen

/// Changes a sample on its way from the hand to the bag; t is in s since the first sample.
using Mishap = std::function<void(double t, int sample, TrackedHands&)>;

void write(const std::string& file, const hand::Score& score, const Mishap& mishap = {}) {
  rosbag::Bag bag(file, rosbag::bagmode::Write);
  bag.setCompression(rosbag::compression::BZ2);
  const int last = static_cast<int>(std::floor(score.duration() * rate));
  for (int i = 0; i <= last; ++i) {
    const double t = static_cast<double>(i) / rate;
    TrackedHands message = tactile_clay::nodes::toMessage(score.sample(t));
    message.header.stamp = epoch + ros::Duration(i / rate, i % rate * 1'000'000'000LL / rate);
    message.header.frame_id = "world";
    auto& hands = message.hands;
    hands.erase(std::remove_if(hands.begin(), hands.end(),
                               [](const TrackedHand& hand) {
                                 const auto& palm = hand.joints[hand::palm].position;
                                 return std::max(std::abs(palm.x), std::abs(palm.y)) > sight;
                               }),
                hands.end());
    if (mishap) mishap(t, i, message);
    bag.write("/hands/tracked", message.header.stamp, message);
  }
}

// The red block of config/scenes/kindergarten.yaml.
hand::Score pressRedBlock(double depth) {
  hand::PressFinger press;
  press.centre = {0.045, 0.05};
  press.block_height = 0.04;
  press.depth = depth;
  return hand::pressFinger(press);
}

// The finger touches the block 1.3 s after the start. With a depth of 4 mm it stays pressed in until 1.93 s.
constexpr double pressed = 1.6;  // s

void loseHand(double t, int, TrackedHands& message) {
  if (t >= pressed) message.hands.clear();
}

void changeId(double t, int, TrackedHands& message) {
  for (TrackedHand& hand : message.hands)
    if (t >= pressed) hand.id += 40;
}

// Two of every six samples of the touching hand are broken, each in a different way.
void breakSamples(double t, int sample, TrackedHands& message) {
  if (t < 1.2 || sample % 6 > 1) return;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   infinity = std::numeric_limits<double>::infinity();
  for (TrackedHand& hand : message.hands) {
    auto& tip = hand.joints[hand::index_tip];
    switch (sample % 12) {
      case 0:
        tip.position.x = nan;
        break;
      case 1:
        tip.position.z = -infinity;
        break;
      case 6:
        tip.orientation.w = nan;
        break;
      default:
        hand.joints[hand::index_distal].position.y = 1e30;
        hand.radii[hand::index_tip] = std::numeric_limits<float>::denorm_min();
    }
  }
}

hand::Score nobody() {
  hand::Score score;
  score.hands.push_back({{0.0, {}}, {2.0, {}}});
  return score;
}

void writeAll(const std::string& folder) {
  const auto file = [&](const char* name) { return folder + "/" + name + ".bag"; };
  write(file("knead"), hand::knead());
  write(file("potter"), hand::potter());
  write(file("press_finger"), pressRedBlock(0.004));
  write(file("press_deeper"), pressRedBlock(0.010));
  write(file("lost_hand"), pressRedBlock(0.004), loseHand);
  write(file("id_change"), pressRedBlock(0.004), changeId);
  write(file("nan"), pressRedBlock(0.004), breakSamples);
  write(file("no_hands"), nobody(), [](double, int, TrackedHands& message) { message.hands.clear(); });
}

}  // namespace

int main(int argc, char** argv) {
  return tactile_clay::tools::runTool("make_bags", usage, argc, argv, [&] {
    if (argc != 2) {
      std::fprintf(stderr, "usage: make_bags FOLDER\n");
      return 2;
    }
    writeAll(argv[1]);
    return 0;
  });
}
