#include "rviz_plugins/shown_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tactile_clay::rviz_plugins {
namespace {

constexpr std::uint8_t am = 0, field = 3, field_circle = 5;

FocalPointArray row(std::uint8_t modulation, const std::vector<float>& pressures, double apart) {
  FocalPointArray message;
  message.modulation = modulation;
  for (std::size_t k = 0; k < pressures.size(); ++k) {
    FocalPoint point;
    point.id = static_cast<std::uint32_t>(k);
    point.position.x = apart * static_cast<double>(k);
    point.pressure = pressures[k];
    message.points.push_back(point);
  }
  return message;
}

std::vector<std::uint32_t> ids(const FocalPointArray& message) {
  std::vector<std::uint32_t> found;
  for (const FocalPoint& point : shownPoints(message)) found.push_back(point.id);
  return found;
}

TEST(ShownPoints, AllFocalPointsAreShown) {
  EXPECT_EQ(ids(row(am, {3e3f, 0, 5e3f}, 0.001)), (std::vector<std::uint32_t>{0, 1, 2}));
}

// Two contacts, 5 mm between samples: rise and fall, bare skin, rise and fall. The second has a slope without
// an end, whose far samples are lower than a neighbour and so no maxima.
TEST(ShownPoints, OfAFieldLocalMaximaAreShownTheStrongestFirst) {
  for (const std::uint8_t modulation : {field, field_circle})
    EXPECT_EQ(ids(row(modulation, {1e3f, 4e3f, 2e3f, 0, 0, 0, 6e3f, 5e3f, 4e3f, 3e3f, 2e3f, 1e3f}, 0.005)),
              (std::vector<std::uint32_t>{6, 1}));
}

TEST(ShownPoints, OfEqualNeighboursOneIsShown) {
  EXPECT_EQ(ids(row(field, {2e3f, 2e3f, 2e3f}, 0.005)), (std::vector<std::uint32_t>{0}));
}

TEST(ShownPoints, BareSkinAndBrokenSamplesAreNotShown) {
  FocalPointArray message = row(field, {0, 1e3f, std::nanf("")}, 0.1);
  message.points[1].position.y = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(ids(message).empty());
}

}  // namespace
}  // namespace tactile_clay::rviz_plugins
