#include "hand/skeleton.h"

#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <stdexcept>

#include "hand/leap_recording.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

HandPose randomPose(Side side, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  HandPose pose;
  pose.side = side;
  pose.scale = 1.05;
  for (int finger = 0; finger < finger_count; ++finger) {
    const FingerLimits& limit = finger_limits[finger];
    const auto within = [&](const Eigen::Vector2d& range) {
      return range[0] + unit(random) * (range[1] - range[0]);
    };
    pose.fingers[finger].abduction = within(limit.abduction);
    for (int i = 0; i < 3; ++i) pose.fingers[finger].flexion[i] = within(limit.flexion[i]);
  }
  pose.wrist = Eigen::Translation3d(0.2, -0.1, 0.3) *
               Eigen::AngleAxisd(3.0 * unit(random), Vector3d(unit(random), 1.0, -0.5).normalized());
  return pose;
}

// Position of a link of the parsed model at given joint angles, in the root's frame.
Eigen::Isometry3d linkPose(const urdf::ModelInterface& model, const std::string& name,
                           const std::map<std::string, double>& angles) {
  const auto link = model.getLink(name);
  if (!link->parent_joint) return Eigen::Isometry3d::Identity();
  const urdf::Joint& joint = *link->parent_joint;
  const auto& p = joint.parent_to_joint_origin_transform;
  double x, y, z, w;
  p.rotation.getQuaternion(x, y, z, w);
  Eigen::Isometry3d pose = linkPose(model, joint.parent_link_name, angles);
  pose = pose * Eigen::Translation3d(p.position.x, p.position.y, p.position.z) *
         Eigen::Quaterniond(w, x, y, z) *
         Eigen::AngleAxisd(angles.at(joint.name), Vector3d(joint.axis.x, joint.axis.y, joint.axis.z));
  return pose;
}

TEST(Skeleton, UrdfIsReadAndMovesAsTheForwardKinematics) {
  std::mt19937 random(5);
  for (const Side side : {Side::left, Side::right}) {
    const auto model = urdf::parseURDF(handUrdf(side, 1.05));
    ASSERT_TRUE(model);
    EXPECT_EQ(model->getRoot()->name, side == Side::left ? "hand_left_wrist" : "hand_right_wrist");
    const std::vector<std::string> names = jointNames(side);
    EXPECT_EQ(names.size(), 20U);
    for (int trial = 0; trial < 5; ++trial) {
      HandPose pose = randomPose(side, random);
      pose.wrist.setIdentity();
      const TrackedHand hand = forwardKinematics(pose);
      const std::vector<double> values = jointAngles(pose);
      std::map<std::string, double> angles;
      for (std::size_t k = 0; k < names.size(); ++k) {
        angles[names[k]] = values[k];
        const auto joint = model->getJoint(names[k]);
        ASSERT_TRUE(joint) << names[k];
        EXPECT_LE(joint->limits->lower - 1e-5, values[k]);
        EXPECT_GE(joint->limits->upper + 1e-5, values[k]);
      }
      for (int finger = 0; finger < finger_count; ++finger)
        for (int i = 1; i < 4; ++i) {
          const Joint joint = fingers[finger][(finger == 0 ? 0 : 1) + i - 1];
          const auto found = linkPose(*model, names[4 * finger + i] + "_link", angles);
          EXPECT_LT((found.translation() - hand.joints[joint].position).norm(), 1e-6)
              << names[4 * finger + i];
        }
    }
  }
  EXPECT_THROW(handUrdf(Side::left, 0.0), std::invalid_argument);
}

// What forward kinematics made, inverse kinematics finds again, from far away.
TEST(Skeleton, FitFindsThePoseOfItsOwnHand) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const HandPose pose = randomPose(trial % 2 ? Side::left : Side::right, random);
    const SkeletonFit fit = fitSkeleton(forwardKinematics(pose));
    EXPECT_LT(fit.error, 1e-4) << trial;
    EXPECT_TRUE(withinLimits(fit.pose));
  }
}

TEST(Skeleton, LimitsHoldForAHandThatDoesNotKeepThem) {
  HandPose pose;
  for (FingerAngles& finger : pose.fingers) {
    finger.flexion = {-1.0, -1.0, -1.0};
    finger.abduction = 1.0;
  }
  const SkeletonFit fit = fitSkeleton(forwardKinematics(pose));
  EXPECT_TRUE(withinLimits(fit.pose));
  EXPECT_TRUE(std::isfinite(fit.error));
  EXPECT_GT(fit.error, 1e-3);
}

class SkeletonOnRecording : public testing::TestWithParam<const char*> {};

// Of each recording the median over its hands and samples of the mean distance of a hand's joints.
TEST_P(SkeletonOnRecording, MedianErrorIsBelowThreeMillimetres) {
  const char* given = std::getenv("TACTILE_CLAY_DATA");
  const fs::path data =
      given != nullptr ? fs::path(given) : fs::path(TACTILE_CLAY_SOURCE_DIR) / "../shared/data";
  const std::string path = (data / "hands" / (std::string(GetParam()) + ".v6.ndjson.gz")).string();
  if (!fs::exists(path)) GTEST_SKIP() << path << " is not here";
  LeapRecording recording;
  SourceOptions options;
  options.file = path;
  recording.open(options);
  std::vector<double> errors;
  TrackedFrame frame;
  for (int k = 0; recording.read(frame, std::chrono::milliseconds(0)) == HandSource::Read::frame; ++k) {
    if (k % 10 != 0) continue;
    for (const TrackedHand& hand : frame.hands) {
      const SkeletonFit fit = fitSkeleton(hand);
      errors.push_back(fit.error);
      EXPECT_TRUE(withinLimits(fit.pose));
    }
  }
  ASSERT_GT(errors.size(), 5U);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  RecordProperty("median_um", static_cast<int>(1e6 * errors[errors.size() / 2]));
  EXPECT_LT(errors[errors.size() / 2], 3e-3);
}

INSTANTIATE_TEST_SUITE_P(All, SkeletonOnRecording,
                         testing::Values("both_hands_low_confidence", "finger_tap", "grab", "left_or_right",
                                         "pinch_and_move", "three_claps"));

}  // namespace
}  // namespace tactile_clay::hand
