// The picture of an array's sound, computed only from array/geometry and array/drive.
#include "nodes/played_drives.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "nodes/array_markers.h"

namespace tactile_clay::nodes {
namespace {

ArrayDrive drive(double stamp, float phase, float amplitude) {
  ArrayDrive message;
  message.header.stamp = ros::Time(stamp);
  message.header.frame_id = "array";
  message.phase = {phase, 0.5f};
  message.amplitude = {amplitude, amplitude};
  return message;
}

// Two arrays that face each other, and a device with its own order of channels.
TEST(ArrayMarkers, TellTheTransducersAsTheyAre) {
  auto layout = ultrasound::arrayLayouts("autd3; usx 0.1 0.2 0.4 3.1416 0.3 0.1");
  std::swap(layout.position[3], layout.position[300]);
  std::swap(layout.normal[3], layout.normal[300]);
  const auto back = layoutOf(*arrayMarkers(layout));
  ASSERT_EQ(back.size(), layout.size());
  for (std::size_t n = 0; n < layout.size(); ++n) {
    EXPECT_EQ(back.position[n], layout.position[n]);
    EXPECT_LT((back.normal[n] - layout.normal[n]).norm(), 1e-12);
  }
}

TEST(ArrayMarkers, OfSomebodyElseAreRefused) {
  EXPECT_THROW(layoutOf({}), std::runtime_error);
  auto markers = *arrayMarkers(ultrasound::arrayLayout("usx"));
  for (auto& marker : markers.markers)
    for (auto& point : marker.points) point = geometry_msgs::Point();
  EXPECT_THROW(layoutOf(markers), std::runtime_error);
}

TEST(PlayedDrives, AreThePatternsOfOneFrame) {
  PlayedDrives played;
  EXPECT_TRUE(played.drives().empty());
  played.add(drive(1.0, 0.1f, 1.0f));
  played.add(drive(1.0, 0.2f, 1.0f));
  ASSERT_EQ(played.drives().size(), 2u);
  EXPECT_EQ(played.drives()[1].phase[0], 0.2f);
  played.add(drive(2.0, 0.3f, 0.5f));
  ASSERT_EQ(played.drives().size(), 1u);
  EXPECT_EQ(played.drives()[0].phase[0], 0.3f);
  EXPECT_EQ(played.drives()[0].amplitude[1], 0.5f);
  EXPECT_EQ(played.frame(), "array");
}

// The array falls silent within a frame, too: with the stamp of the frame that is refused or too old.
TEST(PlayedDrives, SilenceEndsThem) {
  PlayedDrives played;
  played.add(drive(1.0, 0.1f, 1.0f));
  played.add(drive(1.0, 0.0f, 0.0f));
  EXPECT_TRUE(played.drives().empty());
}

TEST(PlayedDrives, DoNotPileUp) {
  PlayedDrives played;
  for (int k = 0; k < 100; ++k) played.add(drive(1.0, 0.1f, 1.0f));
  EXPECT_LE(played.drives().size(), 8u);
}

}  // namespace
}  // namespace tactile_clay::nodes
