#include "nodes/hand_sources/bag_source.h"

#include <ros/console.h>
#include <ros/header.h>
#include <pluginlib/class_list_macros.hpp>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <set>
#include <stdexcept>
#include <vector>

#include "files/input_file.h"
#include "nodes/conversions.h"
#include "nodes/message_check.h"
#include "nodes/topics.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

constexpr std::uint32_t max_message = 1U << 20U;  // bytes; 64 hands have 110 kB

constexpr std::uint32_t max_chunk = 256U << 20U;  // bytes, unpacked; rosbag unpacks a whole one at a time

using Hands = ros::message_traits::DataType<TrackedHands>;
using HandsMd5 = ros::message_traits::MD5Sum<TrackedHands>;

/// The first few names, as a list.
std::string listed(const std::set<std::string>& names) {
  constexpr std::size_t maximum = 8;
  std::string list;
  std::size_t told = 0;
  for (const std::string& name : names) {
    if (told++ == maximum) return list + ", ...";
    list += (list.empty() ? "" : ", ") + name;
  }
  return list;
}

/// The topic to play: the wanted one if the bag has it. If the wanted topic is the usual one and is missing:
/// the only other topic of hands, where topics of rigs in a namespace come first.
std::string topicOfHands(rosbag::Bag& bag, const std::string& file, const std::string& wanted) {
  const std::string topic = wanted.empty() ? topic::hands_tracked : wanted;
  const std::string absolute = topic[0] == '/' ? topic : "/" + topic;
  rosbag::View all(bag);
  std::set<std::string> topics, hands, in_namespaces;
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    // A bag contains the resolved name, with a slash in front.
    if (connection->topic == topic || connection->topic == absolute) return connection->topic;
    topics.insert(connection->topic);
    if (connection->datatype != Hands::value()) continue;
    hands.insert(connection->topic);
    const std::string ending = std::string("/") + topic::hands_tracked;
    if (connection->topic.size() > ending.size() &&
        connection->topic.compare(connection->topic.size() - ending.size(), ending.size(), ending) == 0)
      in_namespaces.insert(connection->topic);
  }
  if (topics.empty())
    throw std::runtime_error(file + ": has no message, expected some on topic '" + topic + "'");
  const std::string missing = file + ": no message on topic '" + topic + "' in this bag";
  if (hands.empty())
    throw std::runtime_error(missing + ", nor others of type " + Hands::value() + "; it has " +
                             listed(topics));
  const bool usual = topic == topic::hands_tracked;
  const std::set<std::string>& candidates = in_namespaces.empty() ? hands : in_namespaces;
  if (!usual || candidates.size() > 1)
    throw std::runtime_error(missing + "; it has hands on " + listed(hands) + ": name one in topic:=");
  ROS_INFO("%s: plays the hands of its topic %s", file.c_str(),
           values::printableLine(*candidates.begin()).c_str());
  return *candidates.begin();
}

void requireTrackedHands(const std::string& file, const rosbag::ConnectionInfo& connection) {
  const std::string what = file + ": topic '" + connection.topic + "' ";
  if (connection.datatype != Hands::value())
    throw std::runtime_error(what + "is of type " + connection.datatype + ", expected " + Hands::value());
  if (connection.md5sum != HandsMd5::value())
    throw std::runtime_error(
        what + "holds " + Hands::value() + " of another version (md5 " + connection.md5sum + ", here " +
        HandsMd5::value() +
        "): play it with the release that recorded it, or convert it with rules for `rosbag fix`");
}

/// Reads records of a bag of version 2 (http://wiki.ros.org/Bags/Format/2.0).
class Records {
 public:
  explicit Records(const std::string& file) : file_(file), in_(file, std::ios::binary) {
    std::string line;
    // rosbag reads other lines, too, but its own is always this one.
    if (!std::getline(in_, line) || line != "#ROSBAG V2.0") fail("begins with none of rosbag's lines");
  }

  /// Goes to a place, in bytes from the beginning.
  void seek(std::uint64_t place) { in_.seekg(static_cast<std::streamoff>(place)); }

  /// Goes on by a number of bytes.
  void skip(std::uint64_t bytes) { in_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur); }

  /// The size in bytes that stands in front of each header and of the data of each record.
  std::uint32_t size() {
    std::uint32_t number = 0;
    if (!in_.read(reinterpret_cast<char*>(&number), sizeof number)) fail("ends within a record");
    return number;
  }

  ros::M_string header() {
    constexpr std::uint32_t longest = 1U << 20U;  // bytes; those that rosbag writes have a hundred
    const std::uint32_t length = size();
    if (length > longest)
      fail("a header of " + std::to_string(length) + " bytes, expected at most " + std::to_string(longest));
    std::vector<std::uint8_t> bytes(length);
    if (!in_.read(reinterpret_cast<char*>(bytes.data()), length)) fail("ends within a header");
    ros::Header header;
    std::string error;
    if (!header.parse(bytes.data(), length, error)) fail(error);
    return *header.getValues();
  }

  template <typename Number>
  Number number(const ros::M_string& header, const std::string& field) const {
    Number number = 0;
    const auto found = header.find(field);
    if (found == header.end() || found->second.size() != sizeof number) fail("a header without " + field);
    std::memcpy(&number, found->second.data(), sizeof number);
    return number;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(file_ + ": damaged bag: " + what);
  }

  std::string file_;
  std::ifstream in_;
};

/// Checks the chunks that rosbag will unpack: those that the index of the bag names, wherever they are.
/// rosbag has opened the bag, so there are no more of them than it has read already.
/// @throws std::runtime_error if a chunk is larger than rosbag should unpack
void requireSmallChunks(const std::string& file) {
  constexpr std::uint64_t entry =
      2 * sizeof(std::uint32_t);  // bytes; a connection and its number of messages
  Records records(file);
  const ros::M_string first = records.header();
  records.seek(records.number<std::uint64_t>(first, "index_pos"));
  for (auto k = records.number<std::uint32_t>(first, "conn_count"); k > 0; --k)
    for (int part = 0; part < 2; ++part) records.skip(records.size());  // header and data
  std::set<std::uint64_t> places;
  for (auto k = records.number<std::uint32_t>(first, "chunk_count"); k > 0; --k) {
    const ros::M_string chunk = records.header();
    places.insert(records.number<std::uint64_t>(chunk, "chunk_pos"));
    records.size();  // rosbag goes by the number of entries
    records.skip(entry * records.number<std::uint32_t>(chunk, "count"));
  }
  for (const std::uint64_t place : places) {
    records.seek(place);
    const ros::M_string chunk = records.header();
    const std::uint32_t unpacked = records.number<std::uint32_t>(chunk, "size");
    if (const std::uint32_t size = std::max(unpacked, records.size()); size > max_chunk)
      throw std::runtime_error(file + ": a chunk of " + std::to_string(size) + " bytes, expected at most " +
                               std::to_string(max_chunk) +
                               "; `rosbag record --chunksize` makes smaller ones");
  }
}

/// Runs `work`, which reads a bag, and returns its result.
/// @throws std::runtime_error with one line: that of `work`, or one about a damaged bag
template <typename Work>
auto reading(const std::string& file, const Work& work) {
  const auto damaged = [&](const std::exception& error) {
    return std::runtime_error(file + ": damaged bag: " + error.what());
  };
  try {
    return work();
  } catch (const ros::Exception& error) {
    throw damaged(error);
  } catch (const std::runtime_error&) {
    throw;
  } catch (const std::exception& error) {
    throw damaged(error);  // with wrong sizes rosbag asks for more memory than there is
  }
}

}  // namespace

void BagSource::open(const hand::SourceOptions& options) {
  file_ = options.file;
  loop_ = options.loop;
  if (file_.empty()) throw std::runtime_error("hands from a bag: expected its file name in 'file'");
  files::requireInput(file_, files::maximum::recording);
  try {
    bag_.open(file_, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error(file_ + ": has no index, as an incomplete bag: `rosbag reindex` makes one");
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(file_ + ": not a readable bag: " + error.what() +
                             "; if it is incomplete, `rosbag reindex` may repair it");
  } catch (const std::exception& error) {
    // With wrong sizes rosbag asks for more memory than there is.
    throw std::runtime_error(file_ + ": not a readable bag: " + error.what());
  }
  if (bag_.getMajorVersion() == 2) requireSmallChunks(file_);  // older ones have none
  reading(file_, [&] {
    const std::string topic = topicOfHands(bag_, file_, options.topic);
    view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(topic));
    for (const rosbag::ConnectionInfo* connection : view_->getConnections())
      requireTrackedHands(file_, *connection);
    next_ = view_->begin();
  });
}

hand::HandSource::Read BagSource::read(hand::TrackedFrame& frame, std::chrono::milliseconds) {
  return reading(file_, [&] {
    if (next_ == view_->end()) {
      if (!loop_) return Read::ended;
      stamps_.rewind();
      next_ = view_->begin();
    }
    if (next_->size() > max_message)
      throw std::runtime_error(file_ + ": a message of " + std::to_string(next_->size()) +
                               " bytes, expected at most " + std::to_string(max_message));
    const auto message = next_->instantiate<TrackedHands>();
    if (!message) throw std::runtime_error(file_ + ": a message that is not a tactile_clay/TrackedHands");
    if (message->hands.size() > max_hands)
      throw std::runtime_error(file_ + ": a message of " + std::to_string(message->hands.size()) +
                               " hands, expected at most " + std::to_string(max_hands));
    frame = toCore(*message);
    if (message->header.stamp.isZero()) frame.stamp = toCore(next_->getTime());
    ++next_;
    frame.stamp = stamps_(frame.stamp);
    return Read::frame;
  });
}

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::BagSource, tactile_clay::hand::HandSource)
