// Hands as skin: closed meshes of capsules, and what is painted on them.
#include "surface/capsule_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "hand/hand_shape.h"
#include "hand/skin_template.h"
#include "surface/samples_on_mesh.h"

namespace tactile_clay::surface::capsule_surface_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double cell = 0.0040;  // m

TEST(CapsuleSurface, LiesOnACapsuleThatIsAlone) {
  const hand::Capsule capsule{{0.0, 0.01, 0.0}, {0.05, 0.02, 0.03}, 0.012, 0.007};
  const TriangleMesh mesh = CapsuleSurface(cell).update({capsule});
  EXPECT_TRUE(isClosedManifold(mesh));
  ASSERT_GT(mesh.position.size(), 200u);
  for (std::size_t c = 0; c < mesh.position.size(); ++c) {
    EXPECT_NEAR(capsule.distance(mesh.position[c].cast<double>()), 0.0, 5e-4);
    const Vector3d out = (mesh.position[c] + 0.002f * mesh.normal[c]).cast<double>();
    EXPECT_GT(capsule.distance(out), 1e-3) << "normals point outwards";
  }
}

TEST(CapsuleSurface, SpheresAndBadCapsules) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3d at(0.1, 0.0, 0.2);
  // One sphere holds the other; a capsule of no length.
  for (const hand::Capsule& ball :
       {hand::Capsule{at, at + Vector3d(0.001, 0, 0), 0.015, 0.002},
        hand::Capsule{at + Vector3d(0.001, 0, 0), at, 0.002, 0.015}, hand::Capsule{at, at, 0.015, 0.015}}) {
    const TriangleMesh mesh = CapsuleSurface(cell).update(
        {ball, {Vector3d(nan, 0, 0), at, 0.01, 0.01}, {at, at * 1e9, 0.01, 0.01}});
    EXPECT_TRUE(isClosedManifold(mesh));
    for (const Vector3f& corner : mesh.position)
      EXPECT_NEAR((corner.cast<double>() - at).norm(), 0.015, 5e-4);
  }
  EXPECT_TRUE(CapsuleSurface(cell).update({}).triangles.empty());
}

TEST(CapsuleSurface, AHandIsOneClosedMeshOnItsModel) {
  const hand::TrackedHand hand = hand::restHand(hand::Side::right, 1.0);
  std::vector<hand::Capsule> capsules;
  for (const hand::Bone& bone : hand::bones) capsules.push_back(hand::boneCapsule(bone, hand));
  const TriangleMesh mesh = CapsuleSurface(cell).update(capsules);
  EXPECT_TRUE(isClosedManifold(mesh));
  std::vector<double> aside;
  for (const Vector3f& corner : mesh.position)
    aside.push_back(hand::handDistance(hand, corner.cast<double>()));
  std::sort(aside.begin(), aside.end());
  EXPECT_GT(aside.front(), -5e-4);
  EXPECT_LT(aside[aside.size() / 2], 1.5e-3);
  EXPECT_LT(aside.back(), 4e-3);  // in the angle between two bones
}

TEST(SamplesOnMesh, MeansAreOfTheSamplesOnThisSide) {
  TriangleMesh mesh;
  mesh.position = {{0, 0, 0}, {0.1f, 0, 0}};
  mesh.normal = {Vector3f::UnitZ(), Vector3f::UnitZ()};
  const std::vector<Vector3f> position = {{0.002f, 0, 0}, {-0.002f, 0, 0}, {0, 0, -0.001f}, {0.02f, 0, 0}};
  const std::vector<Vector3f> normal = {Vector3f::UnitZ(), Vector3f::UnitZ(), -Vector3f::UnitZ(),
                                        Vector3f::UnitZ()};
  const SampleWeights weights = sampleWeights(mesh, position, normal, 0.01f);
  const auto means = meanAt(weights, {{1, 0, 0}, {3, 0, 0}, {100, 0, 0}, {200, 0, 0}});
  EXPECT_NEAR(means[0].x(), 2.0f, 1e-6f);
  EXPECT_EQ(means[1].x(), 0.0f);
  const float weight = 2.0f * 0.96f * 0.96f;
  EXPECT_NEAR(sparseMeanAt(weights, {1, 3, 100, 200}, 4.0f)[0], 2.0f * weight / 4.0f, 1e-5f);
  EXPECT_NEAR(sparseMeanAt(weights, {1, 3, 100, 200}, 0.1f)[0], 2.0f, 1e-5f);
}

}  // namespace
}  // namespace tactile_clay::surface::capsule_surface_test
