#include "rviz_plugins/label_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tactile_clay::rviz_plugins {
namespace {

std::size_t overlaps(const std::vector<LabelBox>& boxes, const std::vector<float>& rises) {
  constexpr float rounding = 1e-5f;
  std::size_t count = 0;
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const float aside =
          0.5f * (boxes[a].width + boxes[b].width) - std::abs(boxes[a].middle - boxes[b].middle);
      const float low_a = boxes[a].bottom + rises[a], low_b = boxes[b].bottom + rises[b];
      const float common =
          std::min(low_a + boxes[a].height, low_b + boxes[b].height) - std::max(low_a, low_b);
      count += aside > rounding && common > rounding;
    }
  }
  return count;
}

TEST(LabelRows, LabelsApartStay) {
  const std::vector<LabelBox> boxes = {{0, 0, 1, 1}, {2, 0.5f, 1, 1}, {0, 3, 1, 1}};
  EXPECT_EQ(risesOf(boxes), (std::vector<float>{0, 0, 0}));
}

TEST(LabelRows, OfTwoTheLowerOneStays) {
  const std::vector<LabelBox> boxes = {{0, 0.25f, 1, 1}, {0.5f, 0, 1, 1}};
  EXPECT_EQ(risesOf(boxes), (std::vector<float>{0.75f, 0}));
}

TEST(LabelRows, RiseAboveObstacles) {
  const std::vector<LabelBox> labels = {{0, 0, 1, 1}, {5, 0, 1, 1}}, obstacles = {{0.2f, 0.5f, 0.1f, 0.25f}};
  EXPECT_EQ(risesOf(labels, obstacles), (std::vector<float>{0.75f, 0}));
}

// A label that rises out of the way of another is not stopped by a third, and rises no farther than it must.
TEST(LabelRows, CrowdsAreStacked) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(0.0f, 4.0f), size(0.3f, 1.0f);
  for (int round = 0; round < 200; ++round) {
    std::vector<LabelBox> boxes;
    for (int k = 0; k < 16; ++k)
      boxes.push_back({place(random), place(random), 2 * size(random), size(random)});
    const auto rises = risesOf(boxes);
    EXPECT_EQ(overlaps(boxes, rises), 0u);
    for (const float rise : rises) {
      EXPECT_GE(rise, 0.0f);
      EXPECT_LT(rise, 16.0f);
    }
  }
}

}  // namespace
}  // namespace tactile_clay::rviz_plugins
