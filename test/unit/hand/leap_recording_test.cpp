#include "hand/leap_recording.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hand/loop_stamps.h"
#include "support/hand_recording.h"
#include "support/scratch_folder.h"

namespace tactile_clay::hand::leap_recording_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::microseconds;
using std::chrono::milliseconds;

class LeapRecordingFile : public ScratchFolder {
 protected:
  std::string writeGz(const std::string& name, const std::string& text) const {
    const std::string path = (folder / name).string();
    gzFile file = gzopen(path.c_str(), "wb");
    gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
    gzclose(file);
    return path;
  }
};

std::string emptyFrame(int microsecond) {
  return R"({"id":1,"timestamp":)" + std::to_string(microsecond) + R"(,"hands":[],"pointables":[]})" + "\n";
}

const std::string& threeFrames() {
  static const std::string text =
      "{\"version\":6}\n" + emptyFrame(1000) + "\n{\"event\":{}}\n" + emptyFrame(1010) + emptyFrame(1024);
  return text;
}

std::vector<long> stamps(LeapRecording& recording, int maximum) {
  std::vector<long> all;
  TrackedFrame frame;
  while (static_cast<int>(all.size()) < maximum &&
         recording.read(frame, milliseconds(0)) == HandSource::Read::frame)
    all.push_back(frame.stamp / microseconds(1));
  return all;
}

std::string openError(const std::string& file) {
  LeapRecording recording;
  try {
    recording.open(fileOptions(file));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST_F(LeapRecordingFile, PlainAndGzippedReadTheSame) {
  for (const std::string& path :
       {write("plain.ndjson", threeFrames()), writeGz("zipped.ndjson.gz", threeFrames())}) {
    LeapRecording recording;
    recording.open(fileOptions(path));
    EXPECT_TRUE(recording.recorded());
    EXPECT_EQ(stamps(recording, 10), (std::vector<long>{1000, 1010, 1024}));
    TrackedFrame frame;
    EXPECT_EQ(recording.read(frame, milliseconds(0)), HandSource::Read::ended);
    EXPECT_EQ(recording.read(frame, milliseconds(0)), HandSource::Read::ended);
    recording.open(fileOptions(path));
    EXPECT_EQ(stamps(recording, 10).size(), 3U);
  }
}

TEST_F(LeapRecordingFile, TheClockGoesOnOverTheLoop) {
  LeapRecording recording;
  recording.open(fileOptions(writeGz("loop.gz", threeFrames()), true));
  // 12 us is the mean frame time.
  EXPECT_EQ(stamps(recording, 8), (std::vector<long>{1000, 1010, 1024, 1036, 1046, 1060, 1072, 1082}));
}

TEST_F(LeapRecordingFile, WhatIsNoRecordingSaysSoWhenOpened) {
  const auto line = [](const std::string& error, const char* part) {
    return error.find(part) != std::string::npos && error.find("expected") != std::string::npos &&
           error.find('\n') == std::string::npos;
  };
  EXPECT_TRUE(line(openError((folder / "none.gz").string()), "No such file"));
  EXPECT_TRUE(line(openError(folder.string()), "is a folder"));
  EXPECT_TRUE(line(openError(""), "no file"));
  EXPECT_TRUE(line(openError(write("empty", "")), "is empty"));
  EXPECT_TRUE(line(openError(writeGz("empty.gz", "")), "holds no frame"));
  EXPECT_TRUE(line(openError(write("version_only", "{\"version\":6}\n")), "holds no frame"));
  EXPECT_TRUE(line(openError(write("text", "a diary\n")), "text:1: is not JSON"));
  EXPECT_TRUE(line(openError(write("binary", std::string("\0\1\2\3\n", 5))), "not text"));
  EXPECT_TRUE(line(openError(write("metadata", "{\"metadata\":{},\"frames\":[]}")), "no frames"));
}

TEST_F(LeapRecordingFile, ABadLineThrowsWithItsNumber) {
  LeapRecording recording;
  recording.open(fileOptions(write("bad", threeFrames() + "{\"hands\":\n")));
  EXPECT_EQ(stamps(recording, 3).size(), 3U);
  TrackedFrame frame;
  try {
    recording.read(frame, milliseconds(0));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("bad:7: is not JSON"), std::string::npos) << error.what();
  }
}

TEST_F(LeapRecordingFile, ATruncatedGzipThrows) {
  std::string frames;
  for (int i = 0; i < 2000; ++i) frames += emptyFrame(1000 + 10 * i + i % 7);
  const std::string path = writeGz("cut.gz", frames);
  fs::resize_file(path, fs::file_size(path) / 2);
  LeapRecording recording;
  EXPECT_THROW(
      {
        recording.open(fileOptions(path));
        stamps(recording, 3000);
      },
      std::runtime_error);
}

TEST_F(LeapRecordingFile, DroppedHandsAreCounted) {
  LeapRecording recording;
  recording.open(
      fileOptions(write("dropped", R"({"id":1,"timestamp":5,"hands":[{"id":3},{"id":4}],"pointables":[]})")));
  TrackedFrame frame;
  EXPECT_EQ(recording.read(frame, milliseconds(0)), HandSource::Read::frame);
  EXPECT_TRUE(frame.hands.empty());
  EXPECT_EQ(recording.droppedHands(), 2U);
  EXPECT_NE(recording.lastDrop().find("dropped:1: hand 4"), std::string::npos);
}

std::string faultOf(const SourceOptions& options) {
  try {
    LeapRecording recording;
    recording.open(options);
    TrackedFrame frame;
    while (recording.read(frame, milliseconds(0)) == HandSource::Read::frame) continue;
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// None of these files blocks its reader or fills the memory: each ends with one line that names the limit.
TEST_F(LeapRecordingFile, LimitsEndWhatHasNoEnd) {
  std::string nested = R"({"id":1,"timestamp":5,"hands":)" + std::string(10'000, '[');
  std::string numbers = R"({"id":1,"timestamp":5,"hands":[1)";
  for (int i = 0; i < 60'000; ++i) numbers += ",1";
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  const std::vector<std::pair<std::string, const char*>> cases = {
      {writeGz("newlines.gz", std::string(20'000'000, '\n')), "no frame in 10001 lines"},
      {writeGz("later.gz", threeFrames() + std::string(20'000'000, '\n')), "no frame in 10001 lines"},
      {write("long", std::string(2'000'000, ' ')), "is longer than 1048576 bytes"},
      {write("deep", nested + "\n"), "has a depth of 10001, expected at most 32"},
      {write("many", numbers + "]}\n"), "has a number of values of 60"},
      {(folder / "fifo").string(), "is a FIFO"},
      {folder.string(), "is a folder"},
      {"/dev/zero", "is a device"},
      {write("empty", ""), "is empty"}};
  for (const auto& [file, words] : cases) {
    const std::string fault = faultOf(fileOptions(file));
    EXPECT_NE(fault.find(words), std::string::npos) << fault;
    EXPECT_NE(fault.find(file), std::string::npos) << fault;
    EXPECT_EQ(fault.find('\n'), std::string::npos) << fault;
  }
}

TEST_F(LeapRecordingFile, OtherUnitsOfTimeAreRefused) {
  const auto recorded = [&](int interval) {  // in units of the timestamps, at 100 Hz
    std::string text = "{\"version\":6}\n";
    for (int i = 1; i <= 20; ++i) text += emptyFrame(i * interval);
    return openError(write("every" + std::to_string(interval), text));
  };
  EXPECT_EQ(recorded(10'000), "");                                                                    // us
  EXPECT_NE(recorded(10).find("frames are 0.01 ms apart, expected 1 to 500 ms"), std::string::npos);  // ms
  EXPECT_NE(recorded(10'000'000).find("frames are 10000 ms apart"), std::string::npos);               // ns
  EXPECT_EQ(recorded(0), "");  // stamps that stand still are repaired
}

TEST(LoopStamps, NoStampMakesThemWrapAround) {
  LoopStamps stamps;
  for (int pass = 0; pass < 5; ++pass) {
    for (const std::chrono::nanoseconds stamp :
         {std::chrono::nanoseconds(0), std::chrono::nanoseconds::max()})
      EXPECT_GE(stamps(stamp).count(), 0);
    stamps.rewind();
  }
}

}  // namespace
}  // namespace tactile_clay::hand::leap_recording_test
