#include "hand/leap_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "support/error_of.h"
#include "support/leap_message.h"

namespace tactile_clay::hand::leap_frame_test {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

void expectSameHand(const TrackedHand& got, const TrackedHand& expected, double tolerance = 1e-9) {
  EXPECT_EQ(got.side, expected.side);
  for (int joint = 0; joint < joint_count; ++joint) {
    const char* name = joint_anatomy[joint].name;
    EXPECT_LT((got.joints[joint].position - expected.joints[joint].position).norm(), tolerance) << name;
    EXPECT_NEAR(got.joints[joint].radius, expected.joints[joint].radius, 1e-9) << name;
    EXPECT_LT(got.joints[joint].orientation.angularDistance(expected.joints[joint].orientation), 0.35)
        << name;
    EXPECT_NEAR(got.joints[joint].orientation.toRotationMatrix().determinant(), 1.0, 1e-9) << name;
  }
}

TrackedHand onlyHand(const json& message) {
  const auto frame = parseLeapFrame(message.dump(), "test");
  EXPECT_TRUE(frame.has_value());
  EXPECT_EQ(frame->dropped, std::vector<std::string>());
  EXPECT_EQ(frame->frame.hands.size(), 1U);
  return frame->frame.hands.empty() ? TrackedHand() : frame->frame.hands[0];
}

TEST(LeapFrame, AxesAndUnitsAreRep103) {
  const Vector3d palm_in_frame(0.03, -0.01, 0.2);
  TrackedHand moved = knownHand(Side::right);
  const Vector3d way = palm_in_frame - moved.joints[palm].position;
  for (JointPose& joint : moved.joints) joint.position += way;
  json message = leapMessage(moved);
  message["hands"][0]["palmPosition"] = {10.0, 200.0, -30.0};  // right of, over and before the tracker
  const auto frame = parseLeapFrame(message.dump(), "test");
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.stamp, std::chrono::microseconds(1234567));
  ASSERT_EQ(frame->dropped.size() + frame->frame.hands.size(), 1U);
  const TrackedHand hand = onlyHand(leapMessage(knownHand(Side::right)));
  EXPECT_DOUBLE_EQ(hand.confidence, 0.75);
  EXPECT_EQ(hand.id, 12U);
  ASSERT_EQ(frame->frame.hands.size(), 1U);
  EXPECT_LT((frame->frame.hands[0].joints[palm].position - palm_in_frame).norm(), 1e-12);
}

TEST(LeapFrame, ReadsACompleteHandOfEitherSide) {
  for (const Side side : {Side::left, Side::right})
    expectSameHand(onlyHand(leapMessage(knownHand(side))), knownHand(side));
}

TEST(LeapFrame, BoneFramesFollowTheBones) {
  for (const Side side : {Side::left, Side::right}) {
    const TrackedHand hand = onlyHand(leapMessage(knownHand(side)));
    const TrackedHand truth = knownHand(side);
    for (const FingerJoints& finger : fingers)
      for (int i = 0; i + 1 < finger.count; ++i) {
        const Eigen::Quaterniond& got = hand.joints[finger[i]].orientation;
        const Vector3d bone =
            (truth.joints[finger[i + 1]].position - truth.joints[finger[i]].position).normalized();
        EXPECT_LT((got * -Vector3d::UnitZ() - bone).norm(), 1e-9);
        EXPECT_GT((got * Vector3d::UnitY()).dot(truth.joints[finger[i]].orientation * Vector3d::UnitY()),
                  0.95);
      }
  }
}

TEST(LeapFrame, MissingFieldsAreReconstructed) {
  for (const Side side : {Side::left, Side::right}) {
    json message = leapMessage(knownHand(side));
    message.erase("currentFrameRate");
    message["hands"][0].erase("wrist");
    message["hands"][0].erase("type");
    message["hands"][0].erase("confidence");
    for (json& pointable : message["pointables"])
      for (const char* key : {"carpPosition", "btipPosition", "type"}) pointable.erase(key);
    const TrackedHand hand = onlyHand(message);
    expectSameHand(hand, knownHand(side));
    EXPECT_EQ(hand.confidence, 1.0);
  }
}

// A service that sends null for unknown values gives the same result as one that leaves them out.
TEST(LeapFrame, AnOptionalFieldThatIsNullIsMissing) {
  json without = leapMessage(knownHand(Side::left)), null = without;
  for (const char* key : {"type", "wrist"}) {
    without["hands"][0].erase(key);
    null["hands"][0][key] = nullptr;
  }
  for (std::size_t i = 0; i < without["pointables"].size(); ++i)
    for (const char* key : {"type", "carpPosition", "btipPosition", "tipPosition"}) {
      without["pointables"][i].erase(key);
      null["pointables"][i][key] = nullptr;
    }
  const auto a = parseLeapFrame(without.dump(), "here"), b = parseLeapFrame(null.dump(), "here");
  ASSERT_EQ(a->frame.hands.size(), 1U);
  ASSERT_EQ(b->frame.hands.size(), 1U) << b->dropped.back();
  EXPECT_EQ(b->frame.hands[0].side, Side::left);
  for (int joint = 0; joint < joint_count; ++joint)
    EXPECT_EQ(a->frame.hands[0].joints[joint].position, b->frame.hands[0].joints[joint].position) << joint;
  null["hands"][0]["palmNormal"] = nullptr;
  const auto required = parseLeapFrame(null.dump(), "here");
  EXPECT_TRUE(required->frame.hands.empty());
  EXPECT_NE(required->dropped.back().find("palmNormal is missing"), std::string::npos);
}

TEST(LeapFrame, BoneTipFollowsTheTipsLineAtTheTablesLength) {
  json message = leapMessage(knownHand(Side::right));
  const TrackedHand truth = knownHand(Side::right);
  for (json& pointable : message["pointables"]) pointable.erase("btipPosition");
  // 4 mm beyond the bone, as trackers give it.
  const Vector3d dip = truth.joints[index_distal].position;
  const Vector3d tip = truth.joints[index_tip].position;
  message["pointables"][1]["tipPosition"] = leapVector(tip + 0.004 * (tip - dip).normalized());
  expectSameHand(onlyHand(message), truth);
  // Without a tip, `direction` is the best information: the direction of the phalanx before.
  message["pointables"][1].erase("tipPosition");
  message["pointables"][1]["direction"] =
      leapVector((dip - truth.joints[index_intermediate].position).normalized(), 1.0);
  const TrackedHand straight = onlyHand(message);
  EXPECT_NEAR((straight.joints[index_tip].position - dip).norm(), (tip - dip).norm(), 1e-9);
  message["pointables"][1].erase("direction");
  EXPECT_LT((onlyHand(message).joints[index_tip].position - straight.joints[index_tip].position).norm(),
            1e-9);
}

TEST(LeapFrame, IdsMayBeStrings) {
  const TrackedHand hand = onlyHand(leapMessage(knownHand(Side::left), "34"));
  EXPECT_EQ(hand.id, 34U);
  json message = leapMessage(knownHand(Side::left), "34");
  for (json& pointable : message["pointables"]) pointable.erase("type");
  expectSameHand(onlyHand(message), knownHand(Side::left));
}

TEST(LeapFrame, FingersAreJoinedToHandsById) {
  json message = leapMessage(knownHand(Side::right), 12);
  const json other = leapMessage(knownHand(Side::left), 7);
  message["hands"].push_back(other["hands"][0]);
  for (const json& pointable : other["pointables"])
    message["pointables"].insert(message["pointables"].begin(), pointable);
  const auto frame = parseLeapFrame(message.dump(), "test");
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->frame.hands.size(), 2U);
  expectSameHand(frame->frame.hands[0], knownHand(Side::right));
  expectSameHand(frame->frame.hands[1], knownHand(Side::left));
}

TEST(LeapFrame, ToolsAreNotFingers) {
  json message = leapMessage(knownHand(Side::right));
  message["pointables"].push_back({{"id", 121}, {"handId", 12}, {"tool", true}, {"tipPosition", {0, 0, 0}}});
  expectSameHand(onlyHand(message), knownHand(Side::right));
}

TEST(LeapFrame, OtherMessagesAreNoFrames) {
  for (const char* text :
       {"", "  \r\n", R"({"version":6,"serviceVersion":"2.3.1+33747"})",
        R"({"event":{"type":"deviceEvent","state":{"attached":true,"id":"LP1","streaming":true}}})"})
    EXPECT_FALSE(parseLeapFrame(text, "test")) << text;
  const auto empty = parseLeapFrame(R"({"id":1,"timestamp":10,"hands":[],"pointables":[]})", "test");
  ASSERT_TRUE(empty);
  EXPECT_TRUE(empty->frame.hands.empty());
}

TEST(LeapFrame, MalformedLinesSayWhatWhereAndWhatWasExpected) {
  json no_time = leapMessage(knownHand(Side::right));
  no_time.erase("timestamp");
  json bad_pointables = leapMessage(knownHand(Side::right));
  bad_pointables["pointables"] = 5;
  json bad_hands = leapMessage(knownHand(Side::right));
  bad_hands["hands"] = "two";
  for (const std::string& text :
       {std::string("{\"hands\":["), std::string("hello"), std::string("[1,2]"), std::string("{}"),
        std::string("\xff\xfe{"), no_time.dump(), bad_pointables.dump(), bad_hands.dump()}) {
    try {
      parseLeapFrame(text, "clip.ndjson:17");
      ADD_FAILURE() << text.substr(0, 40);
    } catch (const std::runtime_error& error) {
      const std::string line = error.what();
      EXPECT_EQ(line.rfind("clip.ndjson:17: ", 0), 0U) << line;
      EXPECT_NE(line.find("expected"), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  }
}

TEST(LeapFrame, AHandWithAnImpossiblePalmOrTooFewFingersIsDroppedAndTheOtherKept) {
  const auto spoilt = [](const std::function<void(json&)>& spoil) {
    json message = leapMessage(knownHand(Side::right), 12);
    const json other = leapMessage(knownHand(Side::left), 7);
    spoil(message);
    message["hands"].push_back(other["hands"][0]);
    for (const json& pointable : other["pointables"]) message["pointables"].push_back(pointable);
    return message.dump();
  };
  const std::vector<std::string> texts = {
      spoilt([](json& m) { m["hands"][0]["palmNormal"][1] = nullptr; }),  // what JSON makes of NaN
      spoilt([](json& m) {
        m["hands"][0]["palmPosition"] = {0.0, 20000.0, 0.0};
      }),
      spoilt([](json& m) { m["hands"][0]["palmNormal"] = m["hands"][0]["direction"]; }),
      spoilt([](json& m) { m["hands"][0]["confidence"] = nullptr; }),
      spoilt([](json& m) { m["hands"][0]["type"] = "middle"; }),
      spoilt([](json& m) { m["hands"][0]["type"] = 1; }),
      spoilt([](json& m) {
        m["hands"][0]["palmPosition"] = {1, 2};
      }),
      spoilt([](json& m) { m["hands"][0]["direction"] = "up"; }),
      spoilt([](json& m) { m["hands"][0]["confidence"] = "high"; }),
      spoilt([](json& m) { m["hands"][0]["wrist"] = json::object(); }),
      spoilt([](json& m) {
        m["hands"][0]["wrist"] = {0.0, nullptr, 0.0};
      }),
      spoilt([](json& m) { m["pointables"] = json::array(); }),
      spoilt([](json& m) { m["pointables"].erase(m["pointables"].begin(), m["pointables"].begin() + 3); }),
      spoilt([](json& m) {
        for (json& p : m["pointables"])
          for (const char* key :
               {"carpPosition", "mcpPosition", "pipPosition", "dipPosition", "btipPosition"})
            p[key] = {0, 0, 0};
      })};
  for (const std::string& text : texts) {
    SCOPED_TRACE(text);
    const auto frame = parseLeapFrame(text, "clip:3");
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->dropped.size(), 1U);
    EXPECT_EQ(frame->dropped[0].rfind("clip:3: hand 12 is dropped: ", 0), 0U) << frame->dropped[0];
    ASSERT_EQ(frame->frame.hands.size(), 1U);
    EXPECT_EQ(frame->frame.hands[0].id, 7U);
  }
}

TEST(LeapFrame, MoreHandsOrPointablesThanAnyoneHasAreRefused) {
  const json one = leapMessage(knownHand(Side::right), 12);
  for (const auto& [list, maximum] : {std::pair("hands", 100), {"pointables", 1000}}) {
    json message = one;
    while (message[list].size() <= static_cast<std::size_t>(maximum)) message[list].push_back(one[list][0]);
    const std::string said = errorOf([&, text = message.dump()] { parseLeapFrame(text, "clip:3"); });
    EXPECT_NE(said.find("clip:3"), std::string::npos) << said;
    EXPECT_NE(said.find("expected at most " + std::to_string(maximum)), std::string::npos) << said;
  }
}

TEST(LeapFrame, AHandWithoutAUsableIdIsDroppedAndTheOtherKept) {
  const json first = leapMessage(knownHand(Side::right), 12), other = leapMessage(knownHand(Side::left), 7);
  for (const json& id : {json(12.5), json(true), json(-3), json(1e300), json("12a"), json(5000000000)}) {
    json message = other;
    message["hands"].push_back(first["hands"][0]);
    message["hands"][1]["id"] = id;
    for (json pointable : first["pointables"]) {
      pointable["handId"] = id;
      message["pointables"].push_back(pointable);
    }
    const auto frame = parseLeapFrame(message.dump(), "clip:3");
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->dropped.size(), 1U) << id;
    EXPECT_EQ(frame->dropped[0].rfind("clip:3: hand ", 0), 0U) << frame->dropped[0];
    ASSERT_EQ(frame->frame.hands.size(), 1U);
    EXPECT_EQ(frame->frame.hands[0].id, 7U);
  }
}

}  // namespace
}  // namespace tactile_clay::hand::leap_frame_test
