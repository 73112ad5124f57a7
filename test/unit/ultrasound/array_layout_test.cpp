#include "ultrasound/array_layout.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

#include "support/shared_data.h"

namespace tactile_clay::ultrasound::array_layout_test {
namespace {

TEST(ArrayLayout, GridsHaveTheirPitchAndAreCentred) {
  const std::vector<std::pair<std::string, double>> pitches = {
      {"usx", 0.0103}, {"uhev1", 0.01047}, {"sonic_surface", 0.0105}};
  for (const auto& [name, pitch] : pitches) {
    const ArrayLayout layout = arrayLayout(name);
    EXPECT_EQ(layout.name, name);
    ASSERT_EQ(layout.size(), 256u);
    ASSERT_EQ(layout.normal.size(), 256u);
    EXPECT_NEAR((layout.position[1] - layout.position[0] - Eigen::Vector3d(pitch, 0, 0)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((layout.position[16] - layout.position[0] - Eigen::Vector3d(0, pitch, 0)).norm(), 0.0, 1e-12);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t n = 0; n < layout.size(); ++n) {
      sum += layout.position[n];
      EXPECT_EQ(layout.normal[n], Eigen::Vector3d(0, 0, 1));
    }
    EXPECT_NEAR(sum.norm(), 0.0, 1e-9);
    EXPECT_NEAR(layout.position[255].x(), 7.5 * pitch, 1e-12);
  }
}

TEST(ArrayLayout, Autd3LacksThreeTransducers) {
  const ArrayLayout layout = arrayLayout("autd3");
  ASSERT_EQ(layout.size(), 249u);
  const auto at = [](int column, int row) {
    return Eigen::Vector3d((column - 8.5) * 0.01016, (row - 6.5) * 0.01016, 0.0);
  };
  const auto has = [&](const Eigen::Vector3d& x) {
    for (const auto& p : layout.position) {
      if ((p - x).norm() < 1e-9) return true;
    }
    return false;
  };
  EXPECT_TRUE(has(at(0, 0)));
  EXPECT_TRUE(has(at(17, 13)));
  EXPECT_TRUE(has(at(3, 1)));
  EXPECT_FALSE(has(at(1, 1)));
  EXPECT_FALSE(has(at(2, 1)));
  EXPECT_FALSE(has(at(16, 1)));
}

TEST(ArrayLayout, UnknownNameListsTheKnownOnes) {
  try {
    arrayLayout("usy");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "unknown array layout 'usy', expected one of: autd3, sonic_surface, uhev1, usx");
  }
}

/// Channels of the grid in reverse order.
std::string reversed() {
  std::ostringstream csv;
  csv << "channel,column,row\n";
  for (int channel = 0; channel < 256; ++channel) {
    csv << channel << ',' << (255 - channel) % 16 << ',' << (255 - channel) / 16 << '\n';
  }
  return csv.str();
}

TEST(ArrayLayout, ChannelTableSetsTheOrder) {
  const ArrayLayout grid = arrayLayout("sonic_surface");
  const ArrayLayout layout = arrayLayout("sonic_surface", reversed());
  ASSERT_EQ(layout.size(), 256u);
  for (std::size_t n = 0; n < 256; ++n) EXPECT_EQ(layout.position[n], grid.position[255 - n]);
}

TEST(ArrayLayout, BadChannelTablesAreRefusedWithTheirLine) {
  const auto message = [](const std::string& csv) {
    try {
      arrayLayout("sonic_surface", csv);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  const std::string header = "channel,column,row\n";
  EXPECT_NE(message("0,0,0\n").find("line 1"), std::string::npos);
  EXPECT_NE(message(header + "0,0,x\n").find("line 2"), std::string::npos);
  EXPECT_NE(message(header + "0,0,0,7\n").find("line 2"), std::string::npos);
  EXPECT_NE(message(header + "256,0,0\n").find("below 256"), std::string::npos);
  EXPECT_NE(message(header + "0,16,0\n").find("column and row of the grid"), std::string::npos);
  EXPECT_NE(message(header + "0,0,0\n1,0,0\n").find("line 3"), std::string::npos);
  EXPECT_NE(message(header + "0,0,0\n0,1,0\n").find("line 3"), std::string::npos);
  EXPECT_NE(message(header + "0,0,0\n").find("255 of 256 channels missing"), std::string::npos);
  EXPECT_EQ(message(reversed()), "accepted");
}

TEST(ArrayLayout, OfTheRealSonicSurfaceIsComplete) {
  std::ifstream file(sharedData("arrays/sonic_surface_channels.csv"));
  if (!file) GTEST_SKIP() << "no arrays/sonic_surface_channels.csv in TACTILE_CLAY_DATA";
  std::ostringstream csv;
  csv << file.rdbuf();
  const ArrayLayout layout = arrayLayout("sonic_surface", csv.str());
  std::set<std::pair<double, double>> places;
  for (const auto& x : layout.position) places.emplace(x.x(), x.y());
  EXPECT_EQ(places.size(), 256u);
}

TEST(ArrayLayouts, SeveralArraysStandInTheirPoses) {
  const ArrayLayout pair = arrayLayouts("usx; autd3 0.2 0 0.3 0 1.5707963267948966 0");
  const ArrayLayout usx = arrayLayout("usx");
  const ArrayLayout autd3 = arrayLayout("autd3");
  ASSERT_EQ(pair.size(), 256u + 249u);
  EXPECT_EQ(pair.name, "usx+autd3");
  for (std::size_t n = 0; n < 256; ++n) EXPECT_EQ(pair.position[n], usx.position[n]);
  for (std::size_t n = 0; n < 249; ++n) {
    // A quarter turn about y takes x to -z and z to x.
    const Eigen::Vector3d& x = autd3.position[n];
    EXPECT_LT((pair.position[256 + n] - Eigen::Vector3d(0.2 + x.z(), x.y(), 0.3 - x.x())).norm(), 1e-12);
    EXPECT_LT((pair.normal[256 + n] - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  }
  EXPECT_EQ(arrayLayouts("usx").position, usx.position);
}

TEST(ArrayLayouts, RefusesWhatItCannotRead) {
  for (const char* wrong :
       {"", "usx 1 2 3", "usx; nothing", "usx 0 0 0 0 0 x", "usx 0 0 0 0 0 0 0", "usx 0 0 nan 0 0 0"}) {
    EXPECT_THROW(arrayLayouts(wrong), std::invalid_argument) << wrong;
  }
}

}  // namespace
}  // namespace tactile_clay::ultrasound::array_layout_test
