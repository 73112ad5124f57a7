#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include "hand/flesh_mesh.h"
#include "hand/neo_hookean.h"
#include "support/bent_finger.h"

namespace tactile_clay::hand::flesh_test {
namespace {

using Eigen::Vector3d;

double totalVolume(const FleshMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.tetrahedra) sum += volume(mesh, t);
  return sum;
}

TEST(FleshMesh, FillsABallAndACone) {
  const Capsule ball{{0.001, 0.002, -0.003}, {0.001, 0.002, -0.003}, 0.02, 0.02};
  EXPECT_NEAR(totalVolume(fillCapsules({ball}, 3e-3)) / (4.0 / 3.0 * M_PI * 8e-6), 1.0, 0.02);
  // A cylinder with two half balls.
  const Capsule rod{{0, 0, 0}, {0.03, 0.02, 0.01}, 0.01, 0.01};
  const double exact = M_PI * 1e-4 * rod.length() + 4.0 / 3.0 * M_PI * 1e-6;
  EXPECT_NEAR(totalVolume(fillCapsules({rod}, 3e-3)) / exact, 1.0, 0.03);
}

TEST(FleshMesh, TetrahedraAreUprightAndNotFlat) {
  const double cell = 5e-3;
  const FleshMesh mesh = fillCapsules(bentFinger(), cell);
  const double regular = cell * cell * cell / 12.0;
  for (const auto& t : mesh.tetrahedra) {
    EXPECT_GT(volume(mesh, t), 1e-3 * regular);
    EXPECT_LT(volume(mesh, t), 3.0 * regular);
  }
}

TEST(FleshMesh, SurfaceIsClosedAndLiesOnTheCapsules) {
  const FleshMesh mesh = fillCapsules(bentFinger(), 5e-3);
  std::map<std::pair<int, int>, int> edges;
  std::set<int> surface;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      ++edges[{t[k], t[(k + 1) % 3]}];
      surface.insert(t[k]);
    }
  // Each edge once in each direction: closed, and wound one way.
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ((edges.count({edge.second, edge.first})), 1U);
  }
  for (const int n : surface) {
    double distance = 1.0;
    for (const Capsule& c : bentFinger()) distance = std::min(distance, c.distance(mesh.nodes[n]));
    EXPECT_NEAR(distance, 0.0, 1e-6);
  }
  // Gauss: the flux of x / 3 out of the surface is the volume.
  double flux = 0.0;
  for (const auto& t : mesh.triangles)
    flux += mesh.nodes[t[0]].cross(mesh.nodes[t[1]]).dot(mesh.nodes[t[2]]) / 6.0;
  EXPECT_NEAR(flux / totalVolume(mesh), 1.0, 1e-9);
}

TEST(FleshMesh, IsTheSameEachTimeAndRefusesACellOfNothing) {
  const FleshMesh a = fillCapsules(bentFinger(), 6e-3), b = fillCapsules(bentFinger(), 6e-3);
  EXPECT_EQ(a.tetrahedra, b.tetrahedra);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_THROW(fillCapsules(bentFinger(), 0.0), std::invalid_argument);
  EXPECT_THROW(fillCapsules(bentFinger(), std::nan("")), std::invalid_argument);
}

// Under a homogeneous small strain the energy is that of linear elasticity, V (mu |e|^2 + lambda/2 tr(e)^2).
TEST(NeoHookean, SmallStrainEnergyIsHookes) {
  const FleshMesh mesh = fillCapsules(bentFinger(), 6e-3);
  const Elasticity material = Elasticity::of(30e3, 0.45);
  const NeoHookean flesh(mesh, material);
  Eigen::Matrix3d strain;
  strain << 8e-3, 3e-3, -2e-3, 3e-3, -5e-3, 4e-3, -2e-3, 4e-3, 6e-3;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  std::vector<FleshNode> nodes = nodesOf(mesh, 0.0F);
  EXPECT_NEAR(flesh.energy(nodes), 0.0, 1e-9);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    nodes[n].head<3>() = (turn * (Eigen::Matrix3d::Identity() + strain) * mesh.nodes[n]).cast<float>();
  const double expected = totalVolume(mesh) * (material.mu * strain.squaredNorm() +
                                               0.5 * material.lambda * std::pow(strain.trace(), 2));
  EXPECT_NEAR(flesh.energy(nodes) / expected, 1.0, 0.03);
}

TEST(NeoHookean, StaysAtRestAndKeepsMomentum) {
  const FleshMesh mesh = fillCapsules(bentFinger(), 6e-3);
  const NeoHookean flesh(mesh, Elasticity::of(30e3, 0.45));
  std::vector<FleshNode> nodes = nodesOf(mesh, 0.01F);
  std::vector<int> squeezed;
  for (int k = 0; k < 100; ++k) flesh.project(nodes, squeezed);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    EXPECT_LT((nodes[n].head<3>().cast<double>() - mesh.nodes[n]).norm(), 1e-6);
  // With equal mobilities the corrections of a constraint add up to zero over all nodes.
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0.0F, 5e-4F);
  Vector3d before = Vector3d::Zero(), after = Vector3d::Zero();
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    nodes[n].head<3>() += Eigen::Vector3f(normal(random), normal(random), normal(random));
    before += nodes[n].head<3>().cast<double>();
  }
  for (int k = 0; k < 10; ++k) flesh.project(nodes, squeezed);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) after += nodes[n].head<3>().cast<double>();
  EXPECT_LT((after - before).norm() / static_cast<double>(mesh.nodes.size()), 1e-7);
}

// A tetrahedron with enough volume at first may be squeezed by the corrections of its neighbours.
TEST(NeoHookean, LeastVolumeIsNotTakenFromNeighbours) {
  const FleshMesh mesh = fillCapsules(bentFinger(), 6e-3);
  const NeoHookean flesh(mesh, Elasticity::of(30e3, 0.45));
  std::vector<FleshNode> shrunk = nodesOf(mesh, 0.0F);
  for (FleshNode& node : shrunk) node.head<3>() *= 0.9F;
  std::vector<int> all;
  flesh.project(shrunk, all);
  ASSERT_EQ(all.size(), flesh.size());
  for (const int seed : {1, 2, 3, 4, 5, 6}) {
    std::mt19937 random(seed);
    std::normal_distribution<float> noise(0.0F, 1e-3F);
    std::vector<FleshNode> nodes = nodesOf(mesh, 1e-3F);
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      nodes[n].head<3>() += Eigen::Vector3f(noise(random), noise(random), noise(random));
    ASSERT_GT(flesh.inverted(nodes).size(), 5U);
    std::vector<Eigen::Vector3f> reaction(nodes.size(), Eigen::Vector3f::Zero());
    flesh.limit(all, nodes, reaction);
    float minimum = 1.0F;
    for (const int t : all) minimum = std::min(minimum, flesh.volumeShare(t, nodes));
    EXPECT_GT(minimum, 0.29F) << seed;
  }
}

// A finger is squashed flat and through itself against its upper half, which is held. Squeezed tetrahedra get
// their minimum volume again, and the held half feels the forces that moved the rest.
TEST(NeoHookean, SqueezedFleshGetsItsLeastVolumeAndPushesBack) {
  const FleshMesh mesh = fillCapsules(bentFinger(), 6e-3);
  const NeoHookean flesh(mesh, Elasticity::of(30e3, 0.45));
  std::vector<FleshNode> nodes = nodesOf(mesh, 1e-3F);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (mesh.nodes[n].y() >= 0.0)
      nodes[n][3] = 0.0F;
    else
      nodes[n][1] *= -0.2F;
  }
  std::vector<int> squeezed;
  std::vector<FleshNode> seen = nodes;  // a pass tells what it visits, and moves it
  flesh.project(seen, squeezed);
  const std::size_t before = flesh.inverted(nodes).size();
  ASSERT_GT(before, 20);
  std::vector<Eigen::Vector3f> reaction(nodes.size(), Eigen::Vector3f::Zero());
  const std::vector<FleshNode> squashed = nodes;
  flesh.limit(squeezed, nodes, reaction);
  EXPECT_LT(flesh.inverted(nodes).size(), before / 4);
  Vector3d sum = Vector3d::Zero(), held = Vector3d::Zero();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    EXPECT_TRUE(nodes[n].allFinite());
    held += reaction[n].cast<double>();
    if (nodes[n][3] > 0.0F)
      sum += (nodes[n] - squashed[n]).head<3>().cast<double>() / static_cast<double>(nodes[n][3]);
    else
      EXPECT_EQ(nodes[n], squashed[n]);
  }
  ASSERT_GT(held.norm(), 0.1);
  EXPECT_LT((sum + held).norm(), 1e-3 * held.norm());
  // At rest nothing changes.
  std::vector<FleshNode> rest = nodesOf(mesh, 1e-3F);
  flesh.project(rest, squeezed);
  EXPECT_TRUE(squeezed.empty());
}

}  // namespace
}  // namespace tactile_clay::hand::flesh_test
