// Recorded bags and other people's nodes depend on the messages as they are: a changed md5 needs a rosbag
// migration rule.
#include <gtest/gtest.h>
#include <tactile_clay/AcousticReport.h>
#include <tactile_clay/ArrayDrive.h>
#include <tactile_clay/ArrayState.h>
#include <tactile_clay/ClayStatus.h>
#include <tactile_clay/FocalPoint.h>
#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/RenderingReport.h>
#include <tactile_clay/RigLatency.h>
#include <tactile_clay/RigNumbers.h>
#include <tactile_clay/TrackedHand.h>
#include <tactile_clay/TrackedHands.h>

#include <fstream>
#include <map>
#include <string>

namespace {

template <typename Message>
std::pair<const std::string, std::string> entry() {
  return {ros::message_traits::DataType<Message>::value(), ros::message_traits::MD5Sum<Message>::value()};
}

std::map<std::string, std::string> checkedIn() {
  std::ifstream file(TACTILE_CLAY_MD5_LIST);
  std::map<std::string, std::string> list;
  for (std::string name, md5; file >> name >> md5;) list[name] = md5;
  return list;
}

TEST(Messages, HaveTheMd5OfTheCheckedInList) {
  using namespace tactile_clay;
  const std::map<std::string, std::string> compiled = {
      entry<AcousticReport>(), entry<ArrayDrive>(),      entry<ArrayState>(),      entry<ClayStatus>(),
      entry<FocalPoint>(),     entry<FocalPointArray>(), entry<RenderingReport>(), entry<RigLatency>(),
      entry<RigNumbers>(),     entry<TrackedHand>(),     entry<TrackedHands>()};
  EXPECT_EQ(compiled, checkedIn());
}

}  // namespace
