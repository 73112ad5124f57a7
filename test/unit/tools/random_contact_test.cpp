#include "tools/random_contact.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tactile_clay::tools {
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

TEST(RandomContact, FollowsFromTheSeed) {
  EXPECT_EQ(randomContact(7, 0.004).at(3).position, randomContact(7, 0.004).at(3).position);
  EXPECT_NE(randomContact(7, 0.004).at(3).position, randomContact(9, 0.004).at(3).position);
}

}  // namespace
}  // namespace tactile_clay::tools
