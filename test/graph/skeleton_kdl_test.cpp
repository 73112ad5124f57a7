// The skeleton's URDF as KDL reads it.
#include <gtest/gtest.h>

#include <kdl/treefksolverpos_recursive.hpp>
#include <kdl_parser/kdl_parser.hpp>

#include "hand/hand_pose.h"
#include "hand/skeleton.h"

namespace tactile_clay::hand {
namespace {

TEST(SkeletonKdl, TreeHasItsJointsAndMovesAsTheForwardKinematics) {
  for (const Side side : {Side::left, Side::right}) {
    const std::string prefix = side == Side::left ? "hand_left_" : "hand_right_";
    HandPose person;
    person.side = side;
    person.scale = 1.07;
    const Skeleton skeleton = measureSkeleton({forwardKinematics(person)});
    KDL::Tree tree;
    ASSERT_TRUE(kdl_parser::treeFromString(skeletonUrdf(skeleton), tree));
    EXPECT_EQ(tree.getNrOfJoints(), 21U);
    EXPECT_EQ(tree.getRootSegment()->first, prefix + "wrist");
    SkeletonPose pose;
    KDL::JntArray angles(tree.getNrOfJoints());
    for (int k = 0; k < skeleton_joint_count; ++k) {
      pose.angles[k] = skeletonLimits(k).dot(Eigen::Vector2d(0.3, 0.7));
      const auto segment = tree.getSegment(skeletonJointName(side, k) + "_link");
      ASSERT_NE(segment, tree.getSegments().end()) << skeletonJointName(side, k);
      angles(GetTreeElementQNr(segment->second)) = pose.angles[k];
    }
    const auto positions = jointPositions(skeleton, pose);
    KDL::TreeFkSolverPos_recursive solver(tree);
    const std::array<const char*, finger_count> names = {"thumb", "index", "middle", "ring", "little"};
    for (int f = 0; f < finger_count; ++f) {
      KDL::Frame tip;
      ASSERT_EQ(solver.JntToCart(angles, tip, prefix + names[f] + "_tip"), 0);
      const Eigen::Vector3d found(tip.p.x(), tip.p.y(), tip.p.z());
      EXPECT_LT((found - positions[fingers[f].tip()]).norm(), 1e-7) << names[f];
    }
  }
}

}  // namespace
}  // namespace tactile_clay::hand
