// A mesh that is cut along a line stays whole, and the line is where it should be.
#include "surface/cut_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "surface/capsule_surface.h"

namespace tactile_clay::surface::cut_mesh_test {
namespace {

using Eigen::Vector3f;

constexpr float cell = 0.004f;    // m
constexpr float height = 0.003f;  // m, of the cut

TriangleMesh ball() {
  hand::Capsule capsule;
  capsule.from = capsule.to = Eigen::Vector3d::Zero();
  capsule.radius_from = capsule.radius_to = 0.02;
  TriangleMesh mesh = CapsuleSurface(cell).update({capsule});
  mesh.color.assign(mesh.position.size(), Vector3f::Zero());
  for (std::size_t c = 0; c < mesh.color.size(); ++c) mesh.color[c].x() = mesh.position[c].z();
  return mesh;
}

std::vector<float> aboveTheCut(const TriangleMesh& mesh) {
  std::vector<float> value;
  for (const Vector3f& at : mesh.position) value.push_back(at.z() - height);
  return value;
}

TEST(CutMesh, PartsLieOnTheirSidesAndMakeTheWholeTogether) {
  const TriangleMesh whole = ball();
  const CutMesh parts = cut(whole, aboveTheCut(whole));
  for (const auto& t : parts.low)
    for (const auto corner : t) EXPECT_LT(parts.mesh.position[corner].z(), height + 1e-6f);
  for (const auto& t : parts.high)
    for (const auto corner : t) EXPECT_GT(parts.mesh.position[corner].z(), height - 1e-6f);
  TriangleMesh both = parts.mesh;
  both.triangles = parts.low;
  both.triangles.insert(both.triangles.end(), parts.high.begin(), parts.high.end());
  EXPECT_NEAR(volumeOf(both), volumeOf(whole), 1e-5 * volumeOf(whole));
  EXPECT_FALSE(parts.low.empty() || parts.high.empty());
}

TEST(CutMesh, CornersOnTheLineHaveWhatTheEdgeHasThere) {
  const TriangleMesh whole = ball();
  const CutMesh parts = cut(whole, aboveTheCut(whole));
  ASSERT_GT(parts.mesh.position.size(), whole.position.size());
  for (std::size_t c = whole.position.size(); c < parts.mesh.position.size(); ++c) {
    EXPECT_NEAR(parts.mesh.position[c].z(), height, 1e-6f);
    EXPECT_NEAR(parts.mesh.color[c].x(), height, 1e-6f);
    EXPECT_NEAR(parts.mesh.normal[c].norm(), 1.0f, 1e-5f);
  }
}

TEST(CutMesh, OneValueACorner) {
  EXPECT_THROW(cut(ball(), {1.0f}), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::surface::cut_mesh_test
