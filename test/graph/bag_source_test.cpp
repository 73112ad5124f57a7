#include "nodes/hand_sources/bag_source.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <std_msgs/String.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "nodes/conversions.h"
#include "support/error_of.h"
#include "support/scratch_folder.h"

namespace tactile_clay::nodes {
namespace {

class Bag : public ScratchFolder {
 protected:
  /// A bag with three samples in each of these topics.
  std::string bag(const std::vector<std::string>& topics, rosbag::compression::CompressionType compression =
                                                              rosbag::compression::Uncompressed) const {
    const std::string file = (folder / "hands.bag").string();
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    bag.setCompression(compression);
    for (int i = 1; i <= 3; ++i)
      for (const std::string& topic : topics) {
        TrackedHands message;
        message.header.stamp = ros::Time(i);
        message.header.frame_id = "/" + topic;
        bag.write(topic, message.header.stamp, message);
      }
    std_msgs::String text;
    if (topics.empty()) bag.write("/chatter", ros::Time(1.0), text);
    return file;
  }

  /// Frame of the samples that are read; expects three samples.
  static std::string played(const std::string& file, const std::string& topic = "") {
    BagSource source;
    hand::SourceOptions options;
    options.file = file;
    options.topic = topic;
    source.open(options);
    hand::TrackedFrame frame;
    int count = 0;
    while (source.read(frame, std::chrono::milliseconds(0)) == hand::HandSource::Read::frame) ++count;
    EXPECT_EQ(count, 3);
    return frame.frame_id;
  }

  static std::string refused(const std::string& file, const std::string& topic = "") {
    return errorOf([&] { played(file, topic); });
  }
};

bool has(const std::string& line, const std::string& part) {
  return line.find(part) != std::string::npos && line.find('\n') == std::string::npos;
}

TEST_F(Bag, HandsOfOneNamespaceArePlayed) {
  EXPECT_EQ(played(bag({"/hands/tracked"})), "hands/tracked");
  EXPECT_EQ(played(bag({"/hands/tracked", "/lab/hands/tracked"})), "hands/tracked");
  EXPECT_EQ(played(bag({"/lab/hands/tracked"})), "lab/hands/tracked");
  EXPECT_EQ(played(bag({"/lab/hands/tracked", "/lab/raw"})), "lab/hands/tracked");
  EXPECT_EQ(played(bag({"/glove"})), "glove");
}

TEST_F(Bag, OfSeveralOneIsNamed) {
  const std::string file = bag({"/left/hands/tracked", "/right/hands/tracked"});
  EXPECT_TRUE(has(refused(file), "/left/hands/tracked, /right/hands/tracked: name one in topic:="));
  EXPECT_EQ(played(file, "/right/hands/tracked"), "right/hands/tracked");
  EXPECT_EQ(played(file, "right/hands/tracked"), "right/hands/tracked");
  EXPECT_TRUE(has(refused(bag({"/lab/hands/tracked"}), "/other"), "it has hands on /lab/hands/tracked"));
}

TEST_F(Bag, CompressedBagsArePlayed) {
  EXPECT_EQ(played(bag({"/hands/tracked"}, rosbag::compression::BZ2)), "hands/tracked");
  EXPECT_EQ(played(bag({"/hands/tracked"}, rosbag::compression::LZ4)), "hands/tracked");
}

TEST_F(Bag, AChunkThatUnpacksToTooMuchIsRefused) {
  const std::string file = bag({"hands/tracked"}, rosbag::compression::BZ2);
  std::fstream bytes(file, std::ios::binary | std::ios::in | std::ios::out);
  const std::string text{std::istreambuf_iterator<char>(bytes), {}};
  const std::size_t at = text.find("size=");
  ASSERT_NE(at, std::string::npos);
  bytes.clear();
  bytes.seekp(static_cast<std::streamoff>(at + 5));
  bytes.write("\0\0\0\x60", 4);
  bytes.close();
  EXPECT_TRUE(has(refused(file), file + ": a chunk of 1610612736 bytes, expected at most 268435456"))
      << refused(file);
}

TEST_F(Bag, AChunkBehindTheIndexIsCheckedAsWell) {
  std::string text;
  {
    std::ifstream whole(bag({"/hands/tracked"}, rosbag::compression::BZ2), std::ios::binary);
    text.assign(std::istreambuf_iterator<char>(whole), {});
  }
  const auto number = [&](const std::string& field) {
    std::uint64_t value = 0;
    std::memcpy(&value, &text[text.find(field) + field.size()], sizeof value);
    return value;
  };
  const std::uint64_t from = number("chunk_pos="), end = number("index_pos=");
  ASSERT_LT(from, end);
  text += std::string(4, '\xff');  // the size of a header that is longer than the file
  const std::uint64_t place = text.size();
  text += text.substr(from, end - from);
  text.replace(text.find("size=", place) + 5, 4, std::string("\0\0\0\x60", 4));
  std::memcpy(&text[text.find("chunk_pos=") + 10], &place, sizeof place);
  EXPECT_TRUE(
      has(refused(write("behind.bag", text)), "a chunk of 1610612736 bytes, expected at most 268435456"))
      << refused(write("behind.bag", text));
}

TEST_F(Bag, ZerosBehindTheIndexAreNotRead) {
  const std::string file = bag({"/hands/tracked"});
  std::filesystem::resize_file(file, 16ULL << 30U);  // bytes, which take no space
  EXPECT_EQ(played(file), "hands/tracked");
}

TEST_F(Bag, WhatCannotBePlayedSaysWhatToDo) {
  EXPECT_TRUE(has(refused(bag({})), "nor others of type tactile_clay/TrackedHands; it has /chatter"));
  EXPECT_TRUE(has(refused(write("empty.bag", "")), "empty.bag"));
  EXPECT_TRUE(has(refused(write("text.bag", "no bag at all")), "text.bag"));
  const std::string file = bag({"/hands/tracked"});
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
  EXPECT_TRUE(has(refused(file), "rosbag reindex")) << refused(file);
  // A bag whose recorder was killed: the place of its index is not written yet.
  std::string text;
  {
    std::ifstream whole(bag({"/hands/tracked"}), std::ios::binary);
    text.assign(std::istreambuf_iterator<char>(whole), {});
  }
  const std::size_t at = text.find("index_pos=");
  ASSERT_NE(at, std::string::npos);
  text.replace(at + 10, 8, std::string(8, '\0'));
  EXPECT_TRUE(has(refused(write("hands.bag.active", text)), "rosbag reindex"));
}

TEST_F(Bag, AnotherVersionOfTheMessageIsToldByItsMd5) {
  std::string text;
  {
    std::ifstream whole(bag({"/hands/tracked"}), std::ios::binary);
    text.assign(std::istreambuf_iterator<char>(whole), {});
  }
  const std::string md5 = ros::message_traits::MD5Sum<TrackedHands>::value(), other(md5.size(), '0');
  for (std::size_t at = text.find(md5); at != std::string::npos; at = text.find(md5))
    text.replace(at, md5.size(), other);
  const std::string line = refused(write("older.bag", text));
  EXPECT_TRUE(has(line, "another version (md5 " + other + ", here " + md5)) << line;
  EXPECT_TRUE(has(line, "the release that recorded it"));
}

}  // namespace
}  // namespace tactile_clay::nodes
