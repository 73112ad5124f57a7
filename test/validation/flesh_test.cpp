// The flesh against Hertz: a ball of radius R pressed on a rigid plane carries F = 4/3 E/(1 - nu^2) sqrt(R)
// d^(3/2) over the area pi R d when its middle comes nearer by d.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "hand/flesh_mesh.h"
#include "hand/neo_hookean.h"
#include "hand/skin_template.h"
#include "hand/soft_hand.h"
#include "support/pressed_hand.h"

namespace tactile_clay::hand::flesh_test {
namespace {

using Eigen::Vector3d;

double hertz(double young, double poisson, double radius, double depth) {
  return 4.0 / 3.0 * young / (1.0 - poisson * poisson) * std::sqrt(radius) * std::pow(depth, 1.5);
}

// A Moebius map of the unit ball to itself, (-k z) + x in the ball's hyperbolic geometry: tetrahedra keep
// their shapes and are (1 - k)/(1 + k) of their size where the ball touches, below.
Vector3d crowdedBelow(const Vector3d& x, double k) {
  const Vector3d a(0.0, 0.0, -k);
  const double ax = 2.0 * a.dot(x), xx = x.squaredNorm();
  return ((1.0 + ax + xx) * a + (1.0 - k * k) * x) / (1.0 + ax + k * k * xx);
}

struct Load {
  double depth, force, area;  // m, N, m^2
};

// Slope of log y against log x.
template <class X, class Y>
double exponent(const std::vector<Load>& loads, X x, Y y) {
  double mx = 0.0, my = 0.0, xy = 0.0, xx = 0.0;
  const auto n = static_cast<double>(loads.size());
  for (const Load& load : loads) {
    mx += std::log(x(load)) / n;
    my += std::log(y(load)) / n;
  }
  for (const Load& load : loads) {
    xy += (std::log(x(load)) - mx) * (std::log(y(load)) - my);
    xx += (std::log(x(load)) - mx) * (std::log(x(load)) - mx);
  }
  return xy / xx;
}
constexpr auto depthOf = [](const Load& load) { return load.depth; };
constexpr auto forceOf = [](const Load& load) { return load.force; };
constexpr auto areaOf = [](const Load& load) { return load.area; };

// A ball of the hand's flesh, with the hand's relaxation, held by its upper half. Where it touches, cells are
// R/24, so that the radius of contact is 2.7 to 5.4 cells. The ball itself differs from Hertz by the order of
// (d/R)^(1/2) (Tatara 1991), hence 15 %.
TEST(Flesh, BallOnAPlaneIsHertz) {
  constexpr double radius = 0.02, crowding = 0.6;
  const SoftHandParameters hand;
  FleshMesh mesh = fillCapsules({{Vector3d::Zero(), Vector3d::Zero(), 1.0, 1.0}}, 1.0 / 6.0);
  for (Vector3d& x : mesh.nodes) x = radius * crowdedBelow(x, crowding);
  const NeoHookean flesh(mesh, Elasticity::of(hand.young, hand.poisson));
  const std::vector<double> stiffness = flesh.stiffness();
  std::vector<FleshNode> nodes(mesh.nodes.size() + unused_flesh_nodes, FleshNode::Zero());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    nodes[n].head<3>() = mesh.nodes[n].cast<float>();
    if (mesh.nodes[n].z() < 0.0) nodes[n][3] = static_cast<float>(1.0 / (hand.relaxation * stiffness[n]));
  }
  std::vector<double> area(mesh.nodes.size(), 0.0);
  for (const auto& t : mesh.triangles)
    for (const int n : t)
      area[n] +=
          (mesh.nodes[t[1]] - mesh.nodes[t[0]]).cross(mesh.nodes[t[2]] - mesh.nodes[t[0]]).norm() / 6.0;

  std::vector<Load> loads;
  for (const double share : {0.0125, 0.025, 0.05}) {
    Load load{share * radius, 0.0, 0.0};
    const auto plane = static_cast<float>(load.depth - radius);
    std::vector<int> squeezed;
    for (int k = 0; k < 800; ++k) {
      flesh.project(nodes, squeezed);
      load.force = load.area = 0.0;
      for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
        if (nodes[n][2] < plane) {
          load.force += (plane - nodes[n][2]) / nodes[n][3];
          load.area += area[n];
          nodes[n][2] = plane;
        }
    }
    std::printf("  ball: d/R %.4f, %.2f of Hertz's force, %.2f of his area\n", share,
                load.force / hertz(hand.young, hand.poisson, radius, load.depth),
                load.area / (M_PI * radius * load.depth));
    EXPECT_NEAR(load.force / hertz(hand.young, hand.poisson, radius, load.depth), 1.0, 0.15) << share;
    EXPECT_NEAR(load.area / (M_PI * radius * load.depth), 1.0, 0.2) << share;
    loads.push_back(load);
  }
  EXPECT_NEAR(exponent(loads, depthOf, forceOf), 1.5, 0.1);
  EXPECT_NEAR(exponent(loads, depthOf, areaOf), 1.0, 0.1);
}

// Lowest point of the index finger's last phalanx if its flesh were rigid.
double lowestOfIndexTip(const SoftHand& soft, double scale) {
  constexpr int phalanx = 6;
  const TrackedHand rest = restHand(Side::right, 1.0);
  const Vector3d centre = bodyCentres(rest)[phalanx];
  const BodyPose& pose = soft.bodies()[phalanx];
  double low = std::numeric_limits<double>::infinity();
  for (const Joint j : {index_distal, index_tip}) {
    const Vector3d x = pose.position + pose.rotation * (scale * (rest.joints[j].position - centre));
    low = std::min(low, x.y() - scale * rest.joints[j].radius);
  }
  return low;
}

// The pad of an index finger, with the parameters that are shipped, on a plane of 40 MPa/m. It touches with
// the ball about the tip, of radius R = 6.6 mm, over bone of R/2. A half space is softer: on a flat
// incompressible layer of thickness h on rigid ground the force is 1 + 1.133 c + 1.283 c^2 + 0.769 c^3 +
// 0.0975 c^4 times Hertz's, c = sqrt(R d)/h (Dimitriadis et al. 2002, Biophys. J. 82:2798). Bone is round and
// flesh can move around it, so the pad lies between the two.
TEST(Flesh, PadOfTheFingerFlattensBetweenHertzAndAThinLayer) {
  const SoftHandParameters flesh;
  const double radius = restHand(Side::right, 1.0).joints[index_tip].radius, layer = 0.5 * radius;
  constexpr int frames = 60, averaged = 15;
  Press press(1000.0, true);
  std::vector<Load> loads;
  for (const double height : {-0.0005, -0.001, -0.002, -0.004, -0.008}) {
    Load load{0.0, 0.0, 0.0};
    for (int k = 0; k < frames; ++k) {
      press.frame(height);
      if (k < frames - averaged) continue;
      load.depth -= lowestOfIndexTip(press.soft(), personScale(press.tracked)) / averaged;
      load.force += press.force / averaged;
      load.area += press.area / averaged;
    }
    if (load.force > 0.0) loads.push_back(load);
  }
  ASSERT_GE(loads.size(), 5U);
  for (std::size_t k = 0; k < loads.size(); ++k) {
    const auto [depth, force, area] = loads[k];
    std::printf("  pad: %.2f mm, %.3f N, %.0f mm^2, %.2f of Hertz's force\n", 1e3 * depth, force, 1e6 * area,
                force / hertz(flesh.young, flesh.poisson, radius, depth));
    if (k > 0) {
      EXPECT_GT(area, loads[k - 1].area) << depth;
      EXPECT_GT(force / depth, loads[k - 1].force / loads[k - 1].depth) << depth;
    }
    if (depth > 1e-3) continue;
    const double c = std::sqrt(radius * depth) / layer;
    const double thin = 1.0 + c * (1.133 + c * (1.283 + c * (0.769 + c * 0.0975)));
    EXPECT_GT(force / hertz(flesh.young, flesh.poisson, radius, depth), 1.0) << depth;
    EXPECT_LT(force / hertz(flesh.young, flesh.poisson, radius, depth), thin) << depth;
  }
  EXPECT_GT(exponent(loads, depthOf, forceOf), 1.2);
  EXPECT_GT(exponent(loads, forceOf, areaOf), 0.2);
  EXPECT_LT(exponent(loads, forceOf, areaOf), 1.0);
}

// The pad of the index finger, with the parameters that are shipped, on a plane of 40 MPa/m, at 54 loads up
// to some 4 N. From three samples of 4 mm^2 on, its area is that of Hertz's a^3 = 3 F R / (4 E*) within a
// quarter. It grows with each load that is half above the one before. Between such loads it may fall by a
// twentieth, when facets of flesh come down or tilt.
TEST(Flesh, AreaOfAPadGrowsWithEachLoadAsHertzs) {
  const SoftHandParameters flesh;
  const double radius = restHand(Side::right, 1.0).joints[index_tip].radius;
  const double modulus = flesh.young / (1.0 - flesh.poisson * flesh.poisson);
  constexpr int frames = 40, averaged = 15;
  Press press(1000.0, true);
  press.frame(0.01);
  std::vector<Load> loads;
  double largest = 0.0;  // m^2
  for (double height = 0.0; height > -0.014; height -= 0.00025) {
    Load load{-height, 0.0, 0.0};
    for (int k = 0; k < frames; ++k) {
      press.frame(height);
      if (k < frames - averaged) continue;
      load.force += press.force / averaged;
      load.area += press.area / averaged;
    }
    const double a = std::cbrt(0.75 * load.force * radius / modulus), hertzs = M_PI * a * a;
    if (hertzs < 12e-6) continue;
    EXPECT_NEAR(load.area / hertzs, 1.0, 0.25) << load.force;
    EXPECT_GT(load.area, 0.95 * largest) << load.force;
    largest = std::max(largest, load.area);
    if (!loads.empty() && load.force < 1.5 * loads.back().force) continue;
    if (!loads.empty()) {
      EXPECT_GT(load.area, loads.back().area) << load.force;
    }
    loads.push_back(load);
    std::printf("  pad: %.3f N, %.1f mm^2, %.2f of Hertz's area\n", load.force, 1e6 * load.area,
                load.area / hertzs);
  }
  EXPECT_GE(loads.size(), 8U);
  EXPECT_GT(press.force, 3.0);
  EXPECT_NEAR(exponent(loads, forceOf, areaOf), 2.0 / 3.0, 0.1);
}

}  // namespace
}  // namespace tactile_clay::hand::flesh_test
