#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "values/pose.h"
#include "values/range.h"
#include "values/text.h"

namespace tactile_clay::values::values_test {
namespace {

// Roll is the first turn, yaw the last: x goes to y by a yaw of 90 degrees, whatever the roll was; then z of
// the body, which a roll of 90 degrees has laid along -y, is along x.
TEST(Pose, TurnsByRollFirstAndByYawLast) {
  const Eigen::Isometry3d pose = poseOf(std::vector<double>{1.0, 2.0, 3.0, M_PI_2, 0.0, M_PI_2});
  EXPECT_TRUE(pose.translation().isApprox(Eigen::Vector3d(1.0, 2.0, 3.0)));
  EXPECT_TRUE((pose.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_TRUE((pose.linear() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX()));
}

TEST(Pose, OfZerosIsExactlyNone) {
  EXPECT_EQ(poseOf(std::vector<double>(6, 0.0)).matrix(), Eigen::Isometry3d::Identity().matrix());
}

TEST(Range, HoldsItsEndsAndNoNan) {
  EXPECT_NO_THROW(requireIn("x", 1, 1, 2));
  EXPECT_NO_THROW(requireIn("x", 2, 1, 2));
  EXPECT_THROW(requireIn("x", 3, 1, 2), std::invalid_argument);
  EXPECT_THROW(requireIn("x", std::numeric_limits<double>::quiet_NaN(), 1.0, 2.0), std::invalid_argument);
}

TEST(Range, WithoutAMaximumRefusesInfinityAndNan) {
  EXPECT_NO_THROW(requireAtLeast("x", 0.0, 0.0));
  EXPECT_THROW(requireAtLeast("x", -1e-9, 0.0), std::invalid_argument);
  EXPECT_NO_THROW(requireAbove("x", 1e-9, 0.0));
  EXPECT_THROW(requireAbove("x", 0.0, 0.0), std::invalid_argument);
  for (const double wrong :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(requireAtLeast("x", wrong, 0.0), std::invalid_argument);
    EXPECT_THROW(requireAbove("x", wrong, 0.0), std::invalid_argument);
  }
}

TEST(Range, SaysWhatWasExpectedByTheErrorThatIsWanted) {
  try {
    requireIn<std::runtime_error>("parameter /clay/rate", 0.0, 1.0, 240.0);
    FAIL() << "expected an error";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "parameter /clay/rate: expected a number from 1 to 240, got 0");
  }
}

TEST(Text, HasSixDigits) {
  EXPECT_EQ(text(0.1), "0.1");
  EXPECT_EQ(text(1234567.0), "1.23457e+06");
}

TEST(Text, FromOutsideIsOnePrintableLine) {
  EXPECT_EQ(printableLine("a\nb\x07%s\x1B[2J\x7F"), "a?b?%s?[2J?");
  EXPECT_EQ(printableLine(u8"ä\u00A0\u009B"), u8"ä\u00A0??");
  EXPECT_EQ(printableLine("\xC2"), "\xC2");
  EXPECT_EQ(printableLine(std::string(1000, 'x')), std::string(longest_line, 'x') + "...");
  EXPECT_EQ(printableLine(u8"xää", 4), u8"xä...");
}

TEST(Numbers, OfATextAreAllOfItOrNothing) {
  EXPECT_EQ(numbersOf(" 1 -2.5\n3e-1 "), (std::vector<double>{1.0, -2.5, 0.3}));
  EXPECT_EQ(numbersOf(" "), std::vector<double>());
  for (const char* wrong : {"1 x", "1 2,3", "1 2 -", "1 nan", "inf 1", "1 1e999"})
    EXPECT_EQ(numbersOf(wrong), std::nullopt) << wrong;
}

}  // namespace
}  // namespace tactile_clay::values::values_test
