#include "tools/random_contact.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tactile_clay::tools::random_contact_test {
namespace {

TEST(RandomContact, IsPressedSkinWithBareSkinAroundIt) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto skin = randomContact(seed, 0.004);
    const auto bare =
        std::find_if(skin.begin(), skin.end(), [](const auto& sample) { return sample.pressure == 0.0f; });
    const auto pressed = bare - skin.begin();
    EXPECT_GE(pressed, 3) << seed;
    EXPECT_GT(static_cast<std::ptrdiff_t>(skin.size()), 2 * pressed) << seed;
    for (auto sample = bare; sample != skin.end(); ++sample)
      EXPECT_EQ(sample->pressure, 0.0f) << "pressed first";
    for (const auto& sample : skin) {
      EXPECT_TRUE(sample.position.allFinite());
      EXPECT_LT(sample.position.head<2>().cwiseAbs().maxCoeff(), 0.08f);
      EXPECT_LE(sample.pressure, 30000.0f);
      EXPECT_FLOAT_EQ(sample.force, sample.pressure * sample.area);
    }
  }
}

// By Hertz the force is 2/3 of the highest pressure on the area of the contact; samples stand for it within
// 15 %.
TEST(RandomContact, PressesAsHertzDoes) {
  for (unsigned seed = 0; seed < 20; seed += 2) {  // palms
    double force = 0.0, area = 0.0, maximum = 0.0;
    for (const auto& sample : randomContact(seed, 0.001)) {
      force += sample.force;
      if (sample.pressure > 0.0f) area += sample.area;
      maximum = std::max(maximum, static_cast<double>(sample.pressure));
    }
    EXPECT_NEAR(force, 2.0 / 3.0 * maximum * area, 0.15 * force) << seed;
  }
}

// The normal is that of the surface through the neighbours of a sample, within 0.1 rad.
TEST(RandomContact, LooksOutOfTheSkin) {
  constexpr double step = 0.0005;
  for (const unsigned seed : {0u, 1u}) {
    const auto skin = randomContact(seed, step);
    int checked = 0;
    for (std::size_t i = 0; i < skin.size(); i += 41) {
      const Eigen::Vector3f* beside[2] = {nullptr, nullptr};
      for (const auto& other : skin)
        for (const int axis : {0, 1}) {
          Eigen::Vector2f way = (other.position - skin[i].position).head<2>();
          way[axis] -= static_cast<float>(step);
          if (way.norm() < 0.1f * static_cast<float>(step)) beside[axis] = &other.position;
        }
      if (beside[0] == nullptr || beside[1] == nullptr || skin[i].normal.z() > -0.7f) continue;
      const Eigen::Vector3f expected =
          (*beside[1] - skin[i].position).cross(*beside[0] - skin[i].position).normalized();
      EXPECT_LT((skin[i].normal - expected).norm(), 0.1f) << seed << " " << i;
      ++checked;
    }
    EXPECT_GT(checked, 20) << seed;
  }
}

TEST(RandomContact, FollowsFromTheSeed) {
  EXPECT_EQ(randomContact(7, 0.004).at(3).position, randomContact(7, 0.004).at(3).position);
  EXPECT_NE(randomContact(7, 0.004).at(3).position, randomContact(9, 0.004).at(3).position);
}

}  // namespace
}  // namespace tactile_clay::tools::random_contact_test
