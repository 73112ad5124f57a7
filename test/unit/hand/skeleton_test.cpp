#include "hand/skeleton.h"

#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "hand/hand_pose.h"
#include "skeleton_limits.h"

namespace tactile_clay::hand::skeleton_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// A person whose bones are not those of the table: each is its own number of times longer.
TrackedHand person(Side side, const HandPose& pose = {}) {
  HandPose posed = pose;
  posed.side = side;
  posed.scale = 1.08;
  return forwardKinematics(posed);
}

Skeleton oddSkeleton(Side side) {
  Skeleton skeleton = measureSkeleton({person(side)});
  double factor = 0.9;
  for (Skeleton::Finger& finger : skeleton.fingers)
    for (double& length : finger.bone) length *= (factor += 0.015);
  return skeleton;
}

SkeletonPose randomPose(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  SkeletonPose pose;
  for (int k = 0; k < skeleton_joint_count; ++k) {
    const Eigen::Vector2d limit = skeletonLimits(k);
    pose.angles[k] = limit[0] + unit(random) * (limit[1] - limit[0]);
  }
  pose.wrist = Eigen::Translation3d(0.2, -0.1, 0.3) *
               Eigen::AngleAxisd(3.0 * unit(random), Vector3d(unit(random), 1.0, -0.5).normalized());
  return pose;
}

TrackedHand tracked(const Skeleton& skeleton, const SkeletonPose& pose) {
  TrackedHand hand;
  hand.side = skeleton.side;
  const auto positions = jointPositions(skeleton, pose);
  for (int j = 0; j < joint_count; ++j) hand.joints[j].position = positions[j];
  return hand;
}

double worst(const SkeletonFit& fit) {
  return *std::max_element(fit.error.begin(), fit.error.end());
}

Isometry3d toEigen(const urdf::Pose& pose) {
  double x, y, z, w;
  pose.rotation.getQuaternion(x, y, z, w);
  return Eigen::Translation3d(pose.position.x, pose.position.y, pose.position.z) *
         Eigen::Quaterniond(w, x, y, z);
}

// Pose of a link of the parsed model at given joint angles, in the root's frame.
Isometry3d linkPose(const urdf::ModelInterface& model, const std::string& name,
                    const std::map<std::string, double>& angles) {
  const auto link = model.getLink(name);
  if (!link->parent_joint) return Isometry3d::Identity();
  const urdf::Joint& joint = *link->parent_joint;
  Isometry3d pose =
      linkPose(model, joint.parent_link_name, angles) * toEigen(joint.parent_to_joint_origin_transform);
  if (joint.type == urdf::Joint::REVOLUTE)
    pose =
        pose * Eigen::AngleAxisd(angles.at(joint.name), Vector3d(joint.axis.x, joint.axis.y, joint.axis.z));
  return pose;
}

TEST(Skeleton, UrdfIsReadAndMovesAsTheForwardKinematics) {
  std::mt19937 random(5);
  const char* fingers_by_name[] = {"thumb", "index", "middle", "ring", "little"};
  for (const Side side : {Side::left, Side::right}) {
    const std::string prefix = side == Side::left ? "hand_left_" : "hand_right_";
    const Skeleton skeleton = oddSkeleton(side);
    const auto model = urdf::parseURDF(skeletonUrdf(skeleton));
    ASSERT_TRUE(model);
    EXPECT_EQ(model->getRoot()->name, prefix + "wrist");
    std::set<std::string> revolute;
    for (const auto& [name, joint] : model->joints_)
      if (joint->type == urdf::Joint::REVOLUTE) revolute.insert(name);
    EXPECT_EQ(revolute.size(), 21U);
    for (int trial = 0; trial < 5; ++trial) {
      SkeletonPose pose = randomPose(random);
      pose.wrist.setIdentity();
      const auto positions = jointPositions(skeleton, pose);
      std::map<std::string, double> angles;
      for (int k = 0; k < skeleton_joint_count; ++k) {
        const std::string name = skeletonJointName(side, k);
        angles[name] = pose.angles[k];
        ASSERT_EQ(revolute.count(name), 1U) << name;
        const auto limits = model->getJoint(name)->limits;
        EXPECT_NEAR(limits->lower, skeletonLimits(k)[0], 1e-8) << name;
        EXPECT_NEAR(limits->upper, skeletonLimits(k)[1], 1e-8) << name;
      }
      for (int f = 0; f < finger_count; ++f) {
        const std::string finger = prefix + fingers_by_name[f];
        const std::array<std::string, 4> links =
            f == 0 ? std::array<std::string, 4>{"_cmc_flexion_link", "_mp_flexion_link", "_ip_flexion_link",
                                                "_tip"}
                   : std::array<std::string, 4>{"_mcp_flexion_link", "_pip_flexion_link", "_dip_flexion_link",
                                                "_tip"};
        for (int i = 0; i < 4; ++i)
          EXPECT_LT((linkPose(*model, finger + links[i], angles).translation() -
                     positions[fingers[f][(f == 0 ? 0 : 1) + i]])
                        .norm(),
                    1e-7)
              << finger << links[i];
      }
    }
  }
}

// The thumb of a straight right hand is on its left (-X), and abduction moves every tip toward it.
TEST(Skeleton, AnglesTurnTowardPalmAndThumbOnBothSides) {
  for (const Side side : {Side::left, Side::right}) {
    const double thumb = side == Side::left ? 1.0 : -1.0;
    const Skeleton skeleton = oddSkeleton(side);
    const auto zero = jointPositions(skeleton, SkeletonPose());
    for (int k = 5; k < skeleton_joint_count; ++k) {
      SkeletonPose pose;
      pose.angles[k] = 0.1;
      const auto bent = jointPositions(skeleton, pose);
      const Joint tip = fingers[(k - 1) / 4].tip();
      if ((k - 1) % 4 == 0)
        EXPECT_GT(thumb * (bent[tip] - zero[tip]).x(), 0.004) << k;
      else
        EXPECT_LT((bent[tip] - zero[tip]).y(), -0.001) << k;
    }
  }
}

TEST(Skeleton, MeasuresThePersonWhateverThePose) {
  std::mt19937 random(8);
  for (const Side side : {Side::left, Side::right}) {
    const Skeleton truth = oddSkeleton(side);
    std::vector<TrackedHand> samples;
    for (int k = 0; k < 5; ++k) samples.push_back(tracked(truth, randomPose(random)));
    const Skeleton measured = measureSkeleton(samples);
    EXPECT_EQ(measured.side, side);
    for (int f = 0; f < finger_count; ++f) {
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(measured.fingers[f].bone[i], truth.fingers[f].bone[i], 1e-9) << f << i;
      EXPECT_NEAR(measured.fingers[f].root.norm(), truth.fingers[f].root.norm(), 1e-6) << f;
    }
  }
  EXPECT_THROW(measureSkeleton({}), std::invalid_argument);
  TrackedHand point;
  EXPECT_THROW(measureSkeleton({point}), std::invalid_argument);
}

// Inverse kinematics finds the pose from which forward kinematics made the hand, without a hint.
TEST(Skeleton, FitFindsThePoseOfItsOwnHand) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 200; ++trial) {
    const Skeleton skeleton = oddSkeleton(trial % 2 ? Side::left : Side::right);
    const SkeletonFit fit = fitSkeleton(skeleton, tracked(skeleton, randomPose(random)));
    EXPECT_LT(worst(fit), 1e-4) << trial;
    EXPECT_TRUE(withinLimits(fit.pose)) << trial;
  }
}

TEST(Skeleton, LimitsHoldForAHandThatDoesNotKeepThem) {
  const Skeleton skeleton = oddSkeleton(Side::right);
  SkeletonPose broken;
  broken.angles.fill(-1.0);
  const SkeletonFit fit = fitSkeleton(skeleton, tracked(skeleton, broken));
  EXPECT_TRUE(withinLimits(fit.pose));
  EXPECT_GT(worst(fit), 5e-3);
  EXPECT_LT(worst(fit), 0.2);
}

}  // namespace
}  // namespace tactile_clay::hand::skeleton_test
