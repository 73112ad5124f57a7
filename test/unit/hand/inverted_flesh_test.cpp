#include "hand/inverted_flesh.h"

#include <gtest/gtest.h>

namespace tactile_clay::hand::inverted_flesh_test {
namespace {

using Eigen::Vector3f;

constexpr int body = 1, finger = 0;  // at the root of the thumb
constexpr std::array<bool, body_count> nothing_pressed{};
constexpr int apex = 3;  // node

FleshMesh tetrahedron() {
  FleshMesh mesh;
  mesh.nodes = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  return mesh;
}

// One tetrahedron, whose apex is 1 cm above its base at rest.
struct Flesh {
  FleshMesh mesh = tetrahedron();
  NeoHookean flesh{mesh, Elasticity::of(30e3, 0.45)};
  std::vector<NodeBinding> bindings = std::vector<NodeBinding>(4, {body, false, palm_body, 0.0F});
  std::vector<FleshNode> nodes = std::vector<FleshNode>(4 + unused_flesh_nodes, FleshNode::Zero());
  float home = 0.01F;  // m, height to which the bones would put the apex
  InvertedFlesh inverted;

  explicit Flesh(float height) {
    for (int n = 0; n < 4; ++n) nodes[n].head<3>() = mesh.nodes[n].cast<float>();
    nodes[apex].z() = height;
  }
  std::array<bool, finger_count> step(const std::array<bool, body_count>& pressed = nothing_pressed) {
    const auto at = [this](int n) -> Vector3f {
      return n == apex ? Vector3f(0.0F, 0.0F, home) : Vector3f(mesh.nodes[n].cast<float>());
    };
    return inverted.step(flesh, bindings, at, pressed, nodes);
  }
  float height() const { return nodes[apex].z(); }
};

// Inside out for so long that it counts as caught; its bones leave it no room either.
Flesh caught() {
  Flesh flesh(-0.01F);
  flesh.home = -0.01F;
  for (int k = 0; k < 17; ++k) {
    EXPECT_FALSE(flesh.inverted.caught()) << k;
    flesh.step();
  }
  EXPECT_TRUE(flesh.inverted.caught());
  return flesh;
}

TEST(InvertedFlesh, IsLedBackUntilItIsRight) {
  Flesh flesh(-0.01F);
  const auto fingers = flesh.step();
  for (int f = 0; f < finger_count; ++f) EXPECT_EQ(fingers[f], f == finger);
  EXPECT_NEAR(flesh.height(), -0.004, 1e-7) << "three tenths of the way";
  flesh.step();
  const float upright = flesh.height();
  EXPECT_GT(upright, 0.0F);
  EXPECT_FALSE(flesh.step()[finger]);
  EXPECT_EQ(flesh.height(), upright) << "what is right is left alone";
}

TEST(InvertedFlesh, IsLeftAloneWhereTheClayPresses) {
  Flesh flesh(-0.01F);
  std::array<bool, body_count> pressed{};
  pressed[body] = true;
  EXPECT_TRUE(flesh.step(pressed)[finger]);
  EXPECT_EQ(flesh.height(), -0.01F);
}

TEST(InvertedFlesh, IsCaughtUntilItHasRoomAndItsBonesLeaveItSome) {
  Flesh flesh = caught();
  flesh.nodes[apex].z() = 0.01F;
  flesh.step();
  EXPECT_TRUE(flesh.inverted.caught()) << "its bones would put it inside out again";
  flesh.home = 0.01F;
  flesh.step();
  EXPECT_FALSE(flesh.inverted.caught());
}

TEST(InvertedFlesh, IsLedBackAgainWhereItsLeastVolumeDoesNotHelp) {
  Flesh flesh = caught();
  flesh.home = 0.01F;
  flesh.nodes[apex].z() = 0.003F;  // upright, with too little room
  for (int k = 0; k < 8; ++k) {
    flesh.step();
    EXPECT_TRUE(flesh.inverted.caught()) << k;
    EXPECT_EQ(flesh.height(), 0.003F) << k;
  }
  flesh.step();
  EXPECT_FALSE(flesh.inverted.caught());
  EXPECT_NEAR(flesh.height(), 0.003 + 0.3 * 0.007, 1e-7);
}

}  // namespace
}  // namespace tactile_clay::hand::inverted_flesh_test
