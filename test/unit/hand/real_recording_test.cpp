#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hand/anatomy.h"
#include "hand/hand_check.h"
#include "hand/kinematic_hand.h"
#include "hand/leap_recording.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand::real_recording_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

// The real recordings, see the package's doc on recordings for where they are looked for.
class RealRecording : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    path = handRecording(GetParam()).string();
    if (!fs::exists(path)) GTEST_SKIP() << path << " is not here";
    recording.open(fileOptions(path));
  }
  // These came from an older tracker, which has no metacarpals, and in four bones other proportions
  // [measured].
  bool old() const {
    const std::string name = GetParam();
    return name == "three_claps" || name == "grab" || name == "both_hands_low_confidence";
  }

  static double oldProportion(int joint) {
    if (joint == thumb_proximal) return 0.8654;
    if (joint == index_intermediate) return 1.0430;
    if (joint == index_distal) return 1.1439;
    if (joint == little_intermediate) return 0.9771;
    return 1.0;
  }

  std::string path;
  LeapRecording recording;
};

TEST_P(RealRecording, EveryFrameIsReadAndEveryHandIsSane) {
  TrackedFrame frame;
  int frames = 0;
  std::chrono::nanoseconds last{-1};
  while (recording.read(frame, milliseconds(0)) == HandSource::Read::frame) {
    ++frames;
    EXPECT_GT(frame.stamp, last);
    last = frame.stamp;
    for (const TrackedHand& hand : frame.hands) {
      EXPECT_EQ(faultOf(hand), "");
      for (const JointPose& joint : hand.joints)
        EXPECT_NEAR(joint.orientation.toRotationMatrix().determinant(), 1.0, 1e-9);
    }
  }
  EXPECT_EQ(recording.droppedHands(), 0U) << recording.lastDrop();
  EXPECT_GE(frames, 89);
}

TEST_P(RealRecording, EveryBoneIsTheTablesTimesOneScale) {
  TrackedFrame frame;
  while (recording.read(frame, milliseconds(0)) == HandSource::Read::frame)
    for (const TrackedHand& hand : frame.hands) {
      const double scale = personScale(hand);
      EXPECT_GE(scale, old() ? 0.99 : 1.03);
      EXPECT_LE(scale, 1.10);
      for (int joint = 0; joint < joint_count; ++joint) {
        if (joint_anatomy[joint].bone_length == 0.0) continue;
        const double ratio =
            (hand.joints[joint].position - hand.joints[joint_anatomy[joint].parent].position).norm() /
            joint_anatomy[joint].bone_length / scale;
        EXPECT_NEAR(ratio, old() ? oldProportion(joint) : 1.0, 0.003) << joint_anatomy[joint].name;
      }
    }
}

// Some clips contain the tracker's own bone frames: rows x, y (dorsal) and z (away from the tip); x of a left
// hand points the other way. The package computes its frames without them.
class RecordingWithBases : public RealRecording {};

TEST_P(RecordingWithBases, DorsalAxesAreThoseOfTheRecordedBases) {
  gzFile file = gzopen(path.c_str(), "rb");
  std::vector<char> line(1U << 20U);
  double sum = 0.0;
  double worst = 0.0;
  int count = 0;
  while (gzgets(file, line.data(), static_cast<int>(line.size())) != nullptr) {
    const auto message = nlohmann::json::parse(line.data());
    const auto frame = parseLeapFrame(line.data(), path);
    for (const auto& pointable : message["pointables"]) {
      if (!pointable.contains("bases")) continue;
      const auto hand = std::find_if(frame->frame.hands.begin(), frame->frame.hands.end(),
                                     [&](const TrackedHand& h) { return h.id == pointable["handId"]; });
      ASSERT_NE(hand, frame->frame.hands.end());
      const FingerJoints& joints = fingers[pointable["type"].get<std::size_t>()];
      for (int i = 0; i + 1 < joints.count; ++i) {
        const auto& y = pointable["bases"][static_cast<std::size_t>(i + 5 - joints.count)][1];
        const Eigen::Vector3d dorsal(-y[2].get<double>(), -y[0].get<double>(), y[1].get<double>());
        const Eigen::Vector3d ours = hand->joints[joints[i]].orientation * Eigen::Vector3d::UnitY();
        const double angle = std::acos(std::clamp(dorsal.dot(ours), -1.0, 1.0));
        sum += angle;
        worst = std::max(worst, angle);
        ++count;
      }
    }
  }
  gzclose(file);
  ASSERT_GT(count, 0);
  RecordProperty("mean_mrad", static_cast<int>(1e3 * sum / count));
  RecordProperty("worst_mrad", static_cast<int>(1e3 * worst));
  EXPECT_LT(sum / count, 0.1);
  EXPECT_LT(worst, 0.5);
}

TEST_P(RealRecording, SkinFollowsWithoutAJumpOfItsSamples) {
  KinematicHands hands(20e-3);
  TrackedFrame frame;
  std::size_t count = 0;
  std::size_t hand_count = 0;
  while (recording.read(frame, milliseconds(0)) == HandSource::Read::frame) {
    const Skin skin = hands.update(frame.hands, frame.stamp);
    if (frame.hands.size() == hand_count) {
      EXPECT_EQ(skin.size(), count);
    }
    count = skin.size();
    hand_count = frame.hands.size();
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(skin.position[i].allFinite() && skin.normal[i].allFinite() && skin.velocity[i].allFinite());
      ASSERT_LT(skin.velocity[i].norm(), 20.0F);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Clips, RealRecording, testing::ValuesIn(hand_recordings),
                         [](const auto& clip) { return std::string(clip.param); });

INSTANTIATE_TEST_SUITE_P(Clips, RecordingWithBases,
                         testing::Values("left_or_right", "pinch_and_move", "finger_tap"),
                         [](const auto& clip) { return std::string(clip.param); });

}  // namespace
}  // namespace tactile_clay::hand::real_recording_test
