#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hand/flesh_mesh.h"
#include "hand/neo_hookean.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

std::vector<FleshNode> nodesOf(const FleshMesh& mesh, float mobility) {
  std::vector<FleshNode> nodes(mesh.nodes.size() + unused_flesh_nodes, FleshNode::Zero());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) nodes[n] << mesh.nodes[n].cast<float>(), mobility;
  return nodes;
}

// Hertz: a ball of radius R on a rigid plane carries 4/3 E/(1 - nu^2) sqrt(R) d^(3/2) when its middle comes
// nearer by d, over a disk of radius sqrt(R d). The mesh resolves the disk by one to two cells.
TEST(NeoHookean, BallOnAPlaneIsHertz) {
  constexpr double radius = 0.02, young = 30e3, poisson = 0.45;
  const FleshMesh mesh = fillCapsules({{Vector3d::Zero(), Vector3d::Zero(), radius, radius}}, 4e-3);
  const NeoHookean flesh(mesh, Elasticity::of(young, poisson));
  const std::vector<double> stiffness = flesh.stiffness();
  for (const double depth : {0.5e-3, 1e-3, 2e-3}) {
    std::vector<FleshNode> nodes = nodesOf(mesh, 0.0F);
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      if (mesh.nodes[n].norm() > 0.3 * radius) nodes[n][3] = static_cast<float>(1.0 / (0.3 * stiffness[n]));
    const auto plane = static_cast<float>(depth - radius);
    double force = 0.0, reach = 0.0;
    std::vector<int> inverted;
    for (int k = 0; k < 600; ++k) {
      flesh.project(nodes, inverted);
      force = reach = 0.0;
      for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
        if (nodes[n][2] < plane) {
          force += (plane - nodes[n][2]) / nodes[n][3];
          nodes[n][2] = plane;
          reach = std::max(reach, static_cast<double>(nodes[n].head<2>().norm()));
        }
    }
    const double hertz =
        4.0 / 3.0 * young / (1.0 - poisson * poisson) * std::sqrt(radius) * std::pow(depth, 1.5);
    EXPECT_NEAR(force / hertz, 1.0, 0.2) << depth;
    EXPECT_NEAR(reach / std::sqrt(radius * depth), 1.0, 0.3) << depth;
  }
}

}  // namespace
}  // namespace tactile_clay::hand
