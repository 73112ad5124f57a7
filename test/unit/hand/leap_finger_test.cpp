// A finger that Leap's service did not see, or that cannot be read: the hand goes on without it.
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hand/anatomy.h"
#include "hand/hand_check.h"
#include "hand/leap_frame.h"
#include "support/leap_message.h"

namespace tactile_clay::hand::leap_finger_test {
namespace {

using nlohmann::json;

struct Spoilt {
  const char* how;
  std::function<void(json& pointables, std::size_t finger)> spoil;
  int lost;           // number of joints of this finger that are missing, counted from its tip; 5: all
  const char* words;  // of the line
};

std::vector<Spoilt> spoiltFingers() {
  const auto set = [](const char* key, const json& value) {
    return [key, value](json& p, std::size_t finger) { p[finger][key] = value; };
  };
  const auto erase = [](const char* key) {
    return [key](json& p, std::size_t finger) { p[finger].erase(key); };
  };
  return {{"no pointable", [](json& p, std::size_t finger) { p.erase(finger); }, 5,
           "no pointable for this finger"},
          {"a number as pointable", [](json& p, std::size_t finger) { p[finger] = 7; }, 5, "not an object"},
          {"half an id of a hand", set("handId", 12.5), 5, "field handId is not"},
          {"type 9", set("type", 9), 5, "field type is not 0 to 4"},
          {"a word as type", set("type", "index"), 5, "field type is not"},
          {"no knuckle", erase("mcpPosition"), 5, "mcpPosition is missing"},
          {"true as knuckle", set("mcpPosition", true), 5, "field mcpPosition is not an array"},
          {"a metacarpal of null", set("carpPosition", {1.0, nullptr, 2.0}), 5, "carpPosition is not finite"},
          {"no pip", erase("pipPosition"), 3, "pipPosition is missing"},
          {"a pip of null", set("pipPosition", nullptr), 3, "pipPosition is missing"},
          {"a dip of null", set("dipPosition", nullptr), 3, "dipPosition is missing"},
          {"null as first number of a dip", set("dipPosition", {nullptr, 1.0, 2.0}), 3,
           "dipPosition is not finite"},
          {"null as last number of a dip", set("dipPosition", {1.0, 2.0, nullptr}), 3,
           "dipPosition is not finite"},
          {"a dip at 1e30", set("dipPosition", {1e30, 0.0, 0.0}), 3, "dipPosition is not finite"},
          {"a dip of two numbers", set("dipPosition", {1, 2}), 3, "field dipPosition is not an array"},
          {"a word as tip", set("btipPosition", "far"), 3, "field btipPosition is not an array"},
          {"no tip of the bone, and a wrong one",
           [](json& p, std::size_t finger) {
             p[finger].erase("btipPosition");
             p[finger]["tipPosition"] = {nullptr, nullptr, nullptr};
           },
           3, "tipPosition is not finite"}};
}

/// Expects that the hand of the message goes on without joints of one finger, and that `judge` says why in
/// one line.
void expectOneFingerLost(const std::string& message, int finger, int lost, const std::string& words) {
  const auto frame = parseLeapFrame(message, "clip:3");
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->dropped, std::vector<std::string>());
  ASSERT_EQ(frame->frame.hands.size(), 1U);
  TrackedHand hand = frame->frame.hands[0];
  const HandFaults faults = judge(hand);
  EXPECT_TRUE(faults.usable);
  EXPECT_EQ(faults.fingers, 1);
  ASSERT_EQ(faults.lines.size(), 1U);
  static const char* const names[] = {"thumb", "index finger", "middle finger", "ring finger",
                                      "little finger"};
  const std::string& line = faults.lines[0];
  EXPECT_EQ(line.rfind("right hand 12, " + std::string(names[finger]) + " left out: joint ", 0), 0U) << line;
  EXPECT_NE(line.find(words), std::string::npos) << line;
  EXPECT_NE(line.find("(clip:3)"), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  const TrackedHand whole = knownHand(Side::right);
  for (int joint = 0; joint < joint_count; ++joint) {
    const int first = finger == 0 ? fingers[0].first : fingers[finger].tip() - lost + 1;
    EXPECT_EQ(hand.missing[joint], joint >= first && joint <= fingers[finger].tip()) << joint;
    EXPECT_TRUE(hand.joints[joint].position.allFinite()) << joint;
    EXPECT_TRUE(hand.missing[joint] ||
                (hand.joints[joint].position - whole.joints[joint].position).norm() < 1e-9)
        << joint;
  }
  // It is told once.
  EXPECT_TRUE(hand.unread.empty());
  EXPECT_EQ(faultOf(hand), "");
}

TEST(LeapFinger, TheHandGoesOnWithoutTheFingerAndOneLineSaysWhy) {
  for (const Spoilt& kind : spoiltFingers())
    for (int finger = 0; finger < finger_count; ++finger) {
      if (finger == 0 && std::string(kind.how) == "a metacarpal of null")
        continue;  // the thumb's is not read
      SCOPED_TRACE(std::string(kind.how) + ", finger " + std::to_string(finger));
      json message = leapMessage(knownHand(Side::right), 12);
      kind.spoil(message["pointables"], static_cast<std::size_t>(finger));
      expectOneFingerLost(message.dump(), finger, kind.lost, kind.words);
    }
}

// Some recorders write numbers that JSON does not have.
TEST(LeapFinger, NumbersThatJsonDoesNotHaveAreOneFingersFault) {
  for (const char* number : {"NaN", "-Infinity", "1e999"}) {
    json message = leapMessage(knownHand(Side::right), 12);
    message["pointables"][4]["dipPosition"][1] = 123.25;
    std::string text = message.dump();
    text.replace(text.find("123.25"), 6, number);
    SCOPED_TRACE(number);
    expectOneFingerLost(text, 4, 3, "joint little_distal: dipPosition is not finite");
  }
}

// A finger of type 9 would be another one, and its own is missing.
TEST(LeapFinger, TwoFingersMayBeLostButNotThree) {
  json message = leapMessage(knownHand(Side::right), 12);
  message["pointables"][3]["type"] = 9;
  message["pointables"][4]["dipPosition"] = nullptr;
  auto frame = parseLeapFrame(message.dump(), "clip:3");
  ASSERT_EQ(frame->frame.hands.size(), 1U);
  const LeftOut out = leaveOutBadHands(frame->frame.hands);
  EXPECT_EQ(out.fingers, 2U);
  EXPECT_EQ(out.lines.size(), 2U);
  message["pointables"][2].erase("pipPosition");
  frame = parseLeapFrame(message.dump(), "clip:3");
  EXPECT_TRUE(frame->frame.hands.empty());
  ASSERT_EQ(frame->dropped.size(), 1U);
  EXPECT_NE(frame->dropped[0].find("pipPosition is missing"), std::string::npos) << frame->dropped[0];
  EXPECT_NE(frame->dropped[0].find("less than three fingers"), std::string::npos) << frame->dropped[0];
}

// Side, wrist and size come from the fingers where the service leaves them out.
TEST(LeapFinger, TheRestIsReconstructedFromTheOtherFingers) {
  for (const Side side : {Side::left, Side::right})
    for (std::size_t finger = 0; finger < finger_count; ++finger) {
      json message = leapMessage(knownHand(side), 12);
      message["hands"][0].erase("type");
      message["hands"][0].erase("wrist");
      for (json& pointable : message["pointables"])
        for (const char* key : {"carpPosition", "btipPosition"}) pointable.erase(key);
      message["pointables"].erase(finger);
      auto frame = parseLeapFrame(message.dump(), "clip:3");
      ASSERT_EQ(frame->dropped, std::vector<std::string>()) << finger;
      TrackedHand hand = frame->frame.hands.at(0);
      EXPECT_EQ(hand.side, side) << finger;
      EXPECT_EQ(judge(hand).lines.size(), 1U) << finger;
      for (int joint = 0; joint < joint_count; ++joint)
        EXPECT_TRUE(hand.missing[joint] ||
                    (hand.joints[joint].position - knownHand(side).joints[joint].position).norm() < 1e-9)
            << finger << ", " << joint;
    }
}

// As with a finger that any other source has elsewhere.
TEST(LeapFinger, AFingerThatIsElsewhereIsMissing) {
  for (const double x : {1000.0, -1500.0}) {
    json message = leapMessage(knownHand(Side::right), 12);
    message["pointables"][3]["dipPosition"][0] = x;
    TrackedHand hand = parseLeapFrame(message.dump(), "clip:3")->frame.hands.at(0);
    const HandFaults faults = judge(hand);
    EXPECT_TRUE(faults.usable) << x;
    EXPECT_EQ(faults.lines.size(), 1U) << x;
    EXPECT_TRUE(hand.missing[ring_tip]) << x;
    EXPECT_FALSE(hand.missing[little_tip]) << x;
  }
}

// A pointable that comes twice: the last one counts, whatever the other is.
TEST(LeapFinger, TheLastPointableOfAFingerCounts) {
  json message = leapMessage(knownHand(Side::right), 12);
  json bad = message["pointables"][4];
  bad["dipPosition"] = nullptr;
  message["pointables"].insert(message["pointables"].begin(), bad);
  TrackedHand hand = parseLeapFrame(message.dump(), "clip:3")->frame.hands.at(0);
  EXPECT_EQ(judge(hand).lines, std::vector<std::string>());
}

}  // namespace
}  // namespace tactile_clay::hand::leap_finger_test
