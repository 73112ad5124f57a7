#include "hand/skeleton.h"

#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include "hand/hand_pose.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand {
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

bool withinLimits(const SkeletonPose& pose) {
  for (int k = 0; k < skeleton_joint_count; ++k) {
    const Eigen::Vector2d limit = skeletonLimits(k);
    if (!(pose.angles[k] >= limit[0] && pose.angles[k] <= limit[1])) return false;
  }
  return true;
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

// Somebody of another size and other proportions than the tables: each bone up to 10 % longer or shorter, the
// palm up to 10 % wider or narrower, the thumb's root elsewhere by up to 4 mm and turned by up to 10 degrees.
struct OtherPerson {
  HandPose pose;
  double width;
  std::array<std::array<double, 5>, finger_count> longer;
  Vector3d thumb_shift;
  Eigen::Quaterniond thumb_turn;
};

TrackedHand handOf(const OtherPerson& person) {
  TrackedHand hand = forwardKinematics(person.pose);
  const auto original = hand.joints;
  for (int f = 0; f < finger_count; ++f) {
    const FingerJoints& joints = fingers[f];
    Vector3d start = original[joints.first].position;
    start.x() *= person.width;
    if (f == 0) start += person.thumb_shift;
    hand.joints[joints.first].position = start;
    for (int i = 1; i < joints.count; ++i) {
      Vector3d bone = person.longer[f][i] * (original[joints[i]].position - original[joints[i - 1]].position);
      if (f == 0) bone = person.thumb_turn * bone;
      if (f > 0 && i == 1) bone.x() *= person.width;
      hand.joints[joints[i]].position = hand.joints[joints[i - 1]].position + bone;
    }
  }
  return hand;
}

// Random poses within the middle four fifths of each range. If all joints are at the ends of their ranges and
// the thumb is turned as well, the skeleton's own ranges leave an error of 3.2 mm.
TEST(Skeleton, FitsPeopleOfOtherSizesAndProportions) {
  std::mt19937 random(21);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  double worst_median = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    OtherPerson somebody;
    somebody.pose.side = trial % 2 == 0 ? Side::right : Side::left;
    somebody.pose.scale = 0.8 + 0.1 * (trial % 5);
    somebody.width = uniform(0.9, 1.1);
    for (auto& finger : somebody.longer)
      for (double& longer : finger) longer = uniform(0.9, 1.1);
    somebody.thumb_shift = Vector3d(uniform(-4e-3, 4e-3), uniform(-4e-3, 4e-3), uniform(-4e-3, 4e-3));
    somebody.thumb_turn =
        Eigen::AngleAxisd(uniform(-M_PI / 18.0, M_PI / 18.0),
                          Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized());
    std::vector<TrackedHand> samples;
    for (int k = 0; k < 60; ++k) {
      for (int f = 0; f < finger_count; ++f) {
        FingerAngles& angles = somebody.pose.fingers[f];
        const auto within = [&](const Eigen::Vector2d& range) {
          return uniform(0.9 * range[0] + 0.1 * range[1], 0.1 * range[0] + 0.9 * range[1]);
        };
        for (int i = 0; i < 3; ++i) angles.flexion[i] = within(finger_limits[f].flexion[i]);
        angles.abduction = within(finger_limits[f].abduction);
      }
      samples.push_back(handOf(somebody));
      for (JointPose& joint : samples.back().joints)
        joint.position += 2e-4 * Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    }
    const Skeleton skeleton = measureSkeleton({samples.begin(), samples.begin() + 30});
    std::vector<double> errors;
    for (const TrackedHand& hand : samples) {
      const SkeletonFit fit = fitSkeleton(skeleton, hand);
      ASSERT_TRUE(withinLimits(fit.pose));
      double sum = 0.0;
      for (int f = 0; f < finger_count; ++f)
        for (int i = 0; i < 4; ++i) sum += fit.error[fingers[f][(f == 0 ? 0 : 1) + i]];
      errors.push_back(sum / 20.0);
    }
    std::nth_element(errors.begin(), errors.begin() + 30, errors.end());
    worst_median = std::max(worst_median, errors[30]);
    EXPECT_LT(errors[30], 3e-3) << "person " << trial << " of size " << somebody.pose.scale;
  }
  std::printf("  worst of 20 people: median %.2f mm\n", 1e3 * worst_median);
}

class SkeletonOnRecording : public testing::TestWithParam<const char*> {};

// As in a live run: measured from the first 30 samples of a side, then fitted to all. The error of a sample
// is the mean over the 20 joints of moving bones, without the easy joints of the rigid palm.
TEST_P(SkeletonOnRecording, MedianErrorIsBelowThreeMillimetres) {
  const auto frames = recordedFrames(GetParam());
  if (!frames) GTEST_SKIP() << handRecording(GetParam()) << " is not here";
  std::map<Side, std::vector<TrackedHand>> hands;
  for (const TrackedFrame& frame : *frames)
    for (const TrackedHand& hand : frame.hands) hands[hand.side].push_back(hand);
  ASSERT_FALSE(hands.empty());
  for (const auto& [side, samples] : hands) {
    ASSERT_GT(samples.size(), 60U);
    const Skeleton skeleton = measureSkeleton({samples.begin(), samples.begin() + 30});
    std::vector<double> moving, all;
    for (std::size_t k = 0; k < samples.size(); k += 3) {
      const SkeletonFit fit = fitSkeleton(skeleton, samples[k]);
      ASSERT_TRUE(withinLimits(fit.pose));
      double sum = 0.0, sum_all = 0.0;
      for (int f = 0; f < finger_count; ++f)
        for (int i = 0; i < 4; ++i) sum += fit.error[fingers[f][(f == 0 ? 0 : 1) + i]];
      for (const double error : fit.error) sum_all += error;
      moving.push_back(sum / 20.0);
      all.push_back(sum_all / joint_count);
    }
    std::sort(moving.begin(), moving.end());
    std::sort(all.begin(), all.end());
    const auto at = [](const std::vector<double>& sorted, double share) {
      return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    };
    std::printf(
        "  %s %s: 20 joints of moving bones median %.2f, p95 %.2f mm; all 26 median %.2f, p95 %.2f mm\n",
        GetParam(), side == Side::left ? "left" : "right", 1e3 * at(moving, 0.5), 1e3 * at(moving, 0.95),
        1e3 * at(all, 0.5), 1e3 * at(all, 0.95));
    EXPECT_LT(at(moving, 0.5), 3e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(All, SkeletonOnRecording, testing::ValuesIn(hand_recordings));

}  // namespace
}  // namespace tactile_clay::hand
