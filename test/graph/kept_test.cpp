#include "nodes/kept.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

namespace tactile_clay::nodes {
namespace {

/// The pipe that keep_running reads, made before the first sign of life.
class Pipe : public testing::Environment {
 public:
  void SetUp() override {
    ASSERT_EQ(::pipe2(ends_, O_NONBLOCK), 0);
    ::setenv(beat_variable, std::to_string(ends_[1]).c_str(), 1);
  }
  static int signs() {
    char beats[64];
    return static_cast<int>(std::max<ssize_t>(::read(ends_[0], beats, sizeof beats), 0));
  }

 private:
  static inline int ends_[2];
};
const auto* const environment = testing::AddGlobalTestEnvironment(new Pipe);

TEST(SignsOfLife, OfOneNodeAreThoseOfTheProcess) {
  for (int k = 0; k < 3; ++k) beat("/alone");
  EXPECT_EQ(Pipe::signs(), 3);
  endOfLife("/alone");
}

TEST(SignsOfLife, OneNodeThatHangsSilencesTheProcess) {
  beat("/hangs");
  beat("/goes_on");
  Pipe::signs();  // that of before the second was known
  beat("/hangs");
  for (int k = 0; k < 10; ++k) beat("/goes_on");
  EXPECT_EQ(Pipe::signs(), 1);
  for (int k = 0; k < 10; ++k) beat("/goes_on");
  EXPECT_EQ(Pipe::signs(), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  beat("/goes_on");
  EXPECT_EQ(silentFor(0.05), "/hangs");
  EXPECT_EQ(silentFor(10.0), "");
  beat("/hangs");
  EXPECT_EQ(Pipe::signs(), 1);
  beat("/goes_on");
  endOfLife("/hangs");  // unloaded
  for (int k = 0; k < 3; ++k) beat("/goes_on");
  EXPECT_GE(Pipe::signs(), 3);
  endOfLife("/goes_on");
}

}  // namespace
}  // namespace tactile_clay::nodes
