// For any skin, a step has a bounded cost, and the clay goes on afterwards. If possible, cost is counted
// instead of timed.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>
#include <string>

#include "clay/clay.h"
#include "clay/contact/contacts.h"
#include "support/setups.h"

namespace tactile_clay::clay::bounded_steps_test {
namespace {

constexpr double spacing = 0.005;  // m
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

std::mt19937 generator(2024);

float uniform(float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(generator);
}
Eigen::Vector3f within(float half) {
  return {uniform(-half, half), uniform(-half, half), uniform(-half, half)};
}
Eigen::Vector3f direction() {
  for (;;) {
    const Eigen::Vector3f v = within(1.0f);
    if (v.norm() > 0.1f && v.norm() < 1.0f) return v.normalized();
  }
}
const Eigen::Vector3f middle(0.0f, 0.0f, 0.015f);  // m, of the block

void add(Skin& skin, const Eigen::Vector3f& x, const Eigen::Vector3f& n, const Eigen::Vector3f& v) {
  skin.position.push_back(x);
  skin.normal.push_back(n);
  skin.velocity.push_back(v);
}

/// A lost hand: the flesh of all 26 joints lies about one place.
Skin handAtOnePlace() {
  Skin skin;
  for (int joint = 0; joint < 26; ++joint)
    append(skin, sampleBall(middle.cast<double>() + 1e-4 * direction().cast<double>(), 0.006 + 0.0008 * joint,
                            0.004));
  return skin;
}

Skin atOnePoint(std::size_t count, bool one_way) {
  Skin skin;
  for (std::size_t k = 0; k < count; ++k)
    add(skin, middle, one_way ? Eigen::Vector3f::UnitX() : direction(), Eigen::Vector3f::Zero());
  return skin;
}

/// Samples at random places, with random directions and velocities.
/// @param speed m/s
Skin scattered(std::size_t count, float speed) {
  Skin skin;
  for (std::size_t k = 0; k < count; ++k) add(skin, middle + within(0.06f), direction(), speed * direction());
  return skin;
}

/// Samples of a palm, some with numbers that no skin can have.
Skin withBadNumbers() {
  Skin skin = samplePlane({0.0, 0.0, 0.03}, -Eigen::Vector3d::UnitZ(), 0.03, 0.004);
  const float wrong[] = {0.0f, nan, infinity, -infinity, 1e30f, -1e30f, 1e-30f};
  for (int k = 0; k < 400; ++k) {
    Eigen::Vector3f x = middle + within(0.03f), n = direction(), v = within(1.0f);
    Eigen::Vector3f* const of[] = {&x, &n, &v};
    (*of[k % 3])[k % 2] = wrong[k % 7];
    if (k % 5 == 0) n *= uniform(0.0f, 1e3f);
    add(skin, x, n, v);
  }
  std::vector<std::size_t> order(skin.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::shuffle(order.begin(), order.end(), generator);
  Skin mixed;
  for (const std::size_t k : order) add(mixed, skin.position[k], skin.normal[k], skin.velocity[k]);
  return mixed;
}

/// The same hand twice, from above and below, and skin around the whole block that faces inwards.
Skin withoutRoom() {
  Skin skin;
  for (int twice = 0; twice < 2; ++twice) {
    for (const double side : {-1.0, 1.0})
      append(skin,
             samplePlane({0.0, 0.0, 0.02 + 0.002 * side}, -side * Eigen::Vector3d::UnitZ(), 0.04, 0.003));
    Skin shell = sampleBall(middle.cast<double>(), 0.02, 0.003);
    for (Eigen::Vector3f& n : shell.normal) n = -n;
    append(skin, shell);
  }
  return skin;
}

class BoundedSteps : public testing::Test {
 protected:
  BoundedSteps() {
    ClayConfig config;
    config.spacing = spacing;
    config.threads = 2;
    clay_ = std::make_unique<Clay>(config, std::vector<Material>{Material{}}, block(6, 6, 6, spacing));
    generator.seed(7);
  }

  void bear(const std::string& name, const Skin& skin) {
    SCOPED_TRACE(name);
    const auto start = std::chrono::steady_clock::now();
    constexpr int frames = 2, steps = 4;  // of a frame
    std::uint64_t maximum = 0;
    for (int k = 0; k < frames; ++k) {
      clay_->advance(skin, {ground()}, 1.0 / 60.0);
      maximum = std::max(maximum, clay_->statistics().samples_looked_at);
    }
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / frames;
    RecordProperty(name, std::to_string(maximum));
    std::printf("%-30s %6zu samples, %9lu looked at, %.3f s a frame\n", name.c_str(), skin.size(),
                static_cast<unsigned long>(maximum), seconds);
    EXPECT_LE(maximum, 2U * steps * Contacts::max_looks);
    EXPECT_LT(seconds, 10.0);  // on a busy machine
    for (int k = 0; k < 15; ++k) clay_->advance({}, {ground()}, 1.0 / 60.0);
    const Particles& p = clay_->particles();
    for (std::size_t i = 0; i < p.size(); ++i) {
      ASSERT_TRUE(p.position.at(i).allFinite() && p.velocity.at(i).allFinite());
      ASSERT_LE(p.position.at(i).cwiseAbs().maxCoeff(), 1.0f);
    }
    EXPECT_EQ(clay_->statistics().rejected_displacements, 0U);
  }

  std::unique_ptr<Clay> clay_;
};

TEST_F(BoundedSteps, AHandThatIsOnePlace) {
  bear("hand_at_one_place", handAtOnePlace());
}
TEST_F(BoundedSteps, ManySamplesAtOnePoint) {
  bear("one_way", atOnePoint(10000, true));
  bear("all_ways", atOnePoint(10000, false));
}
TEST_F(BoundedSteps, SamplesAllAbout) {
  bear("still", scattered(10000, 0.0f));
  bear("slow", scattered(10000, 1.0f));
  bear("fast", scattered(10000, 49.0f));
  bear("beyond_all_speed", scattered(10000, 1e30f));
  bear("as_many_as_may_be", scattered(maxSkinSamples(spacing), 1.0f));
}
TEST_F(BoundedSteps, NumbersThatNoSkinHas) {
  for (int k = 0; k < 3; ++k) bear("bad_numbers", withBadNumbers());
}
TEST_F(BoundedSteps, SkinThatLeavesNoRoom) {
  bear("without_room", withoutRoom());
  Skin all = withoutRoom();
  append(all, handAtOnePlace());
  append(all, scattered(5000, 2.0f));
  bear("all_at_once", all);
}
/// Skin under the table and within it.
TEST_F(BoundedSteps, SamplesInsideSolids) {
  Skin skin = scattered(5000, 1.0f);
  for (Eigen::Vector3f& x : skin.position) x.z() -= 0.07f;
  bear("in_the_table", skin);
}

TEST_F(BoundedSteps, TooManySamplesAreRefusedAndTheClayIsAsItWas) {
  const Sculpture before = clay_->sculpture();
  EXPECT_THROW(clay_->advance(atOnePoint(1'000'000, true), {ground()}, 1.0 / 60.0), std::invalid_argument);
  Skin uneven = atOnePoint(3, true);
  uneven.velocity.pop_back();
  EXPECT_THROW(clay_->advance(uneven, {ground()}, 1.0 / 60.0), std::invalid_argument);
  EXPECT_EQ(clay_->time(), 0.0);
  clay_->advance({}, {ground()}, 1.0 / 60.0);
  EXPECT_GT(clay_->time(), 0.0);
  EXPECT_EQ(maxSkinSamples(spacing), 40000U);
}

}  // namespace
}  // namespace tactile_clay::clay::bounded_steps_test
