#include "nodes/hand_sources/bag_source.h"

#include <ros/console.h>
#include <pluginlib/class_list_macros.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

#include "files/input_file.h"
#include "nodes/conversions.h"
#include "nodes/message_check.h"
#include "nodes/topics.h"

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
  ROS_INFO("%s: plays the hands of its topic %s", file.c_str(), candidates.begin()->c_str());
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

/// A number in the format of rosbag.
std::optional<std::uint32_t> readNumber(std::istream& in) {
  std::array<char, sizeof(std::uint32_t)> bytes{};
  if (!in.read(bytes.data(), bytes.size())) return std::nullopt;
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data(), sizeof number);
  return number;
}

/// Checks the headers of all chunks (http://wiki.ros.org/Bags/Format/2.0). What is damaged is left to rosbag.
/// @throws std::runtime_error if a chunk is larger than rosbag should unpack
void requireSmallChunks(const std::string& file) {
  constexpr std::uint32_t longest = 1U << 20U;  // bytes, of a header
  const std::string chunk = "op=\x05", size_of = "size=";
  std::ifstream in(file, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line != "#ROSBAG V2.0") return;
  while (const auto header_size = readNumber(in)) {
    std::string header(std::min(*header_size, longest), '\0');
    if (*header_size > longest || !in.read(header.data(), *header_size)) return;
    const std::size_t at = header.find(size_of);
    if (header.find(chunk) != std::string::npos && at != std::string::npos &&
        at + size_of.size() + sizeof(std::uint32_t) <= header.size()) {
      std::istringstream number(header.substr(at + size_of.size()));
      if (const auto size = readNumber(number); *size > max_chunk)
        throw std::runtime_error(file + ": a chunk of " + std::to_string(*size) +
                                 " bytes, expected at most " + std::to_string(max_chunk) +
                                 "; `rosbag record --chunksize` makes smaller ones");
    }
    const auto data_size = readNumber(in);
    if (!data_size || !in.seekg(*data_size, std::ios::cur)) return;
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
  requireSmallChunks(file_);
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
