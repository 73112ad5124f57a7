#include "hand/skin_loads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace tactile_clay::hand::skin_loads_test {
namespace {

using Eigen::Vector3f;

constexpr float first_guess = 1000.0F;  // N/m, of a clay of which nothing is known
constexpr int memory = 4;               // frames that a sample which was let go of is remembered
constexpr float forgiving = 0.25F;      // of the stiffness, a frame that the clay has let go
const Vector3f up = Vector3f::UnitZ();

/// Samples in the middle of triangles of their own, 10 mm apart along x, on flesh that gives `give` m/N to
/// each.
struct Flesh {
  explicit Flesh(int samples, float give = 1e-4F) : loads(points(samples)) {
    for (int i = 0; i < samples; ++i)
      for (int k = 0; k < 3; ++k) nodes.push_back({0.01F * static_cast<float>(i), 0.0F, 0.0F, 3.0F * give});
  }
  static std::vector<FleshPoint> points(int samples) {
    std::vector<FleshPoint> points;
    for (int i = 0; i < samples; ++i)
      points.push_back(
          {{3 * i, 3 * i + 1, 3 * i + 2}, Vector3f::Constant(1.0F / 3.0F), static_cast<std::uint8_t>(i % 2)});
    return points;
  }
  std::vector<Vector3f> at() const {
    std::vector<Vector3f> at;
    for (const FleshPoint& point : points(static_cast<int>(nodes.size()) / 3))
      at.push_back(point.position(nodes));
    return at;
  }
  void move(int sample, const Vector3f& way) {
    for (int k = 0; k < 3; ++k) nodes[3 * sample + k].head<3>() += way;
  }
  void step() {
    loads.apply(nodes);
    loads.project(nodes);
  }
  /// Force that rigid flesh feels at sample 0 when the sample was moved by `way`; the flesh stays in its
  /// place.
  Vector3f feltAt(const Vector3f& way) {
    std::vector<FleshNode> stiff = nodes;
    for (FleshNode& node : stiff) node[3] = 1e-12F;
    for (int k = 0; k < 3; ++k) stiff[k].head<3>() += way;
    SkinLoads trial = loads;
    trial.apply(stiff);
    trial.project(stiff);
    return trial.force().cast<float>();
  }

  std::vector<FleshNode> nodes;
  SkinLoads loads;
};

TEST(SkinLoads, OfNoForceAreNone) {
  Flesh flesh(2);
  flesh.loads.give({}, flesh.at());
  EXPECT_TRUE(flesh.loads.empty());
  flesh.step();
  EXPECT_EQ(flesh.loads.strength(), 0.0);
  EXPECT_EQ(flesh.at(), Flesh(2).at());
}

// f - K (x - x_then): the more the flesh gives way, the less force the clay gives.
TEST(SkinLoads, AForceGivesWayWithTheFlesh) {
  Flesh flesh(2);
  const Vector3f before = flesh.at()[1];
  flesh.loads.give({{1, 0.4F * up}}, flesh.at());
  EXPECT_EQ(flesh.loads.pressed(), (std::array<bool, body_count>{false, true}));
  flesh.step();
  const Vector3f way = flesh.at()[1] - before;
  EXPECT_GT(way.z(), 1e-5F);
  EXPECT_NEAR(flesh.loads.force().z(), 0.4 - first_guess * way.z(), 1e-5);
  EXPECT_NEAR(way.z(), 1e-4 * flesh.loads.force().z(), 1e-8) << "the flesh carries what presses it";
  EXPECT_EQ(flesh.at()[0], Vector3f::Zero());
}

TEST(SkinLoads, OneSampleTakesAtMostFiveNewtons) {
  Flesh flesh(1);
  const Vector3f direction = Vector3f(1.0F, 2.0F, 2.0F) / 3.0F;
  for (const float size : {5.1F, 1e3F, 1e30F}) {
    Flesh pressed(1);
    pressed.loads.give({{0, size * direction}}, pressed.at());
    EXPECT_NEAR(pressed.loads.strength(), 5.0, 1e-4) << size;
    EXPECT_LT((pressed.loads.force().cast<float>() - 5.0F * direction).norm(), size > 1e6F ? 2.0F : 1e-4F);
  }
  flesh.loads.give({{0, Vector3f::Constant(std::numeric_limits<float>::max())}}, flesh.at());
  EXPECT_NEAR(flesh.loads.strength(), 5.0, 1e-4);
  flesh.step();
  EXPECT_TRUE(flesh.at()[0].allFinite());
}

TEST(SkinLoads, AForceTooWeakForADirectionIsNone) {
  for (const float size : {1e-12F, 1e-25F, std::numeric_limits<float>::denorm_min()}) {
    Flesh flesh(1);
    flesh.loads.give({{0, size * up}}, flesh.at());
    flesh.step();
    EXPECT_TRUE(flesh.at()[0].allFinite()) << size;
    EXPECT_TRUE(flesh.loads.empty()) << size;
  }
}

TEST(SkinLoads, ForcesOnOneSampleAddUpInAnyOrder) {
  Flesh a(3), b(3);
  a.loads.give({{2, 1.5F * up}, {0, 1.0F * up}, {2, 2.0F * up}, {1, 4.0F * up}, {1, 4.0F * up}}, a.at());
  b.loads.give({{0, 1.0F * up}, {1, 8.0F * up}, {2, 3.5F * up}}, b.at());
  EXPECT_NEAR(a.loads.strength(), 1.0 + 5.0 + 3.5, 1e-5) << "and are no way round the bound";
  EXPECT_EQ(a.loads.strength(), b.loads.strength());
  a.step();
  b.step();
  EXPECT_EQ(a.at(), b.at());
}

TEST(SkinLoads, AHandTakesFiftyNewtonsAtOnceAndMoreSlowly) {
  Flesh flesh(60);
  std::vector<SkinForce> forces;
  for (std::uint32_t i = 0; i < 60; ++i) forces.push_back({i, 4.0F * up});
  double before = 0.0;
  for (int frame = 0; frame < 60; ++frame) {
    flesh.loads.give(forces, flesh.at());
    const double now = flesh.loads.strength();
    EXPECT_LE(now, frame == 0 ? 50.0 + 1e-3 : 1.04 * before + 1e-3) << frame;
    EXPECT_GE(now, before - 1e-3) << frame;
    before = now;
  }
  EXPECT_NEAR(before, 120.0, 0.5);
}

// Jolts of the clay are averaged; a force that stays is felt as it is.
TEST(SkinLoads, AreAveragedOverFrames) {
  Flesh flesh(1);
  flesh.loads.give({{0, 1.0F * up}}, flesh.at());
  flesh.loads.give({{0, 3.0F * up}}, flesh.at());
  EXPECT_NEAR(flesh.loads.strength(), 0.2 * 1.0 + 0.8 * 3.0, 1e-5);
  for (int frame = 0; frame < 20; ++frame) flesh.loads.give({{0, 3.0F * up}}, flesh.at());
  EXPECT_NEAR(flesh.loads.strength(), 3.0, 1e-5);
  // Two that cancel out have no direction, and press nothing.
  flesh.loads.give({{0, -0.75F * up}}, flesh.at());
  flesh.step();
  EXPECT_NEAR(flesh.loads.strength(), 0.0, 1e-6);
  EXPECT_TRUE(flesh.at()[0].allFinite());
}

TEST(SkinLoads, OnlyPush) {
  Flesh flesh(1);
  flesh.loads.give({{0, 0.5F * up}}, flesh.at());
  EXPECT_NEAR(flesh.feltAt(Vector3f::Zero()).z(), 0.5, 1e-5);
  EXPECT_NEAR(flesh.feltAt(-1e-3F * up).z(), 1.5, 1e-4) << "deeper in the clay";
  EXPECT_EQ(flesh.feltAt(1e-3F * up), Vector3f::Zero()) << "out of the clay";
}

TEST(SkinLoads, HoldSidewaysNoMoreThanFrictionDoes) {
  Flesh flesh(1);
  flesh.loads.give({{0, 0.5F * up}}, flesh.at());
  const Vector3f stuck = flesh.feltAt(0.3e-3F * Vector3f::UnitX());
  EXPECT_NEAR(stuck.x(), -0.3, 1e-4);
  const Vector3f slides = flesh.feltAt(5e-3F * Vector3f::UnitX());
  EXPECT_NEAR(slides.z(), 0.5, 1e-4);
  EXPECT_NEAR(slides.x(), -0.5, 1e-4);
}

// A sample that the clay released is free, and comes back slowly.
TEST(SkinLoads, RememberForSomeFramesWhereTheClayLetGo) {
  Flesh flesh(2);
  flesh.loads.give({{0, 0.5F * up}}, flesh.at());
  float before = first_guess * 1e-3F;
  for (int age = 1; age <= memory; ++age) {
    flesh.loads.give({}, flesh.at());
    ASSERT_FALSE(flesh.loads.empty()) << age;
    EXPECT_EQ(flesh.feltAt(Vector3f::Zero()), Vector3f::Zero()) << age;
    EXPECT_EQ(flesh.feltAt(1e-3F * up), Vector3f::Zero()) << age;
    const float back = flesh.feltAt(-1e-3F * up).z();
    EXPECT_NEAR(back / before, forgiving, 0.01F) << age;
    before = back;
  }
  flesh.loads.give({}, flesh.at());
  EXPECT_TRUE(flesh.loads.empty());
  EXPECT_EQ(flesh.loads.pressed(), (std::array<bool, body_count>{}));
}

// A clay of k N/m, into which sample 0 goes and out of which it comes.
float learnt(Flesh& flesh, float k) {
  float depth = 1e-4F;
  for (int frame = 0; frame < 40; ++frame) {
    const float next = 1e-4F * (1.0F + 0.5F * std::sin(static_cast<float>(frame)));
    flesh.move(0, (depth - next) * up);
    depth = next;
    flesh.loads.give({{0, k * depth * up}}, flesh.at());
  }
  const float step = 1e-5F;
  return (flesh.feltAt(-step * up) - flesh.feltAt(Vector3f::Zero())).z() / step;
}

TEST(SkinLoads, LearnHowStiffTheClayIs) {
  for (const float k : {400.0F, 1500.0F, 8000.0F}) {
    Flesh flesh(1);
    EXPECT_NEAR(learnt(flesh, k), k, 0.03F * k);
  }
  Flesh soft(1), stiff(1);
  EXPECT_NEAR(learnt(soft, 10.0F), 300.0F, 100.0F) << "it forgets slowly, down to 200 N/m";
  EXPECT_NEAR(learnt(stiff, 30000.0F), 10000.0F, 300.0F) << "no more than that";
}

TEST(SkinLoads, OfOneBodySayNothingOfAnother) {
  Flesh flesh(2);
  learnt(flesh, 8000.0F);
  flesh.loads.clear();
  flesh.loads.give({{1, 0.5F * up}}, flesh.at());
  flesh.step();
  const double way = flesh.at()[1].z();
  EXPECT_NEAR(flesh.loads.force().z(), 0.5 - first_guess * way, 1e-4);
}

TEST(SkinLoads, ClearedKeepWhatTheyLearntAndResetForgetIt) {
  Flesh flesh(1);
  const float k = learnt(flesh, 8000.0F);
  flesh.loads.clear();
  EXPECT_TRUE(flesh.loads.empty());
  const auto stiffness = [&] {
    flesh.loads.give({{0, 0.5F * up}}, flesh.at());
    return (flesh.feltAt(-1e-5F * up) - flesh.feltAt(Vector3f::Zero())).z() / 1e-5F;
  };
  EXPECT_NEAR(stiffness(), k, 0.03F * k);
  flesh.loads.reset();
  EXPECT_TRUE(flesh.loads.empty());
  EXPECT_NEAR(stiffness(), first_guess, 0.03F * first_guess);
}

}  // namespace
}  // namespace tactile_clay::hand::skin_loads_test
