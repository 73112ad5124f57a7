#include "nodes/chain.h"

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <algorithm>

#include "nodes/graph_connections.h"

namespace tactile_clay::nodes {

/// The stamp of any message that begins with a header.
struct StampOnly {
  ros::Time stamp;
};

}  // namespace tactile_clay::nodes

namespace ros::message_traits {
template <>
struct MD5Sum<tactile_clay::nodes::StampOnly> {
  static const char* value() { return "*"; }
  static const char* value(const tactile_clay::nodes::StampOnly&) { return value(); }
};
template <>
struct DataType<tactile_clay::nodes::StampOnly> {
  static const char* value() { return "*"; }
  static const char* value(const tactile_clay::nodes::StampOnly&) { return value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
/// Only reads: nobody sends this type.
template <>
struct Serializer<tactile_clay::nodes::StampOnly> {
  static void read(IStream& stream, tactile_clay::nodes::StampOnly& message) {
    std::uint32_t sequence = 0;
    stream.next(sequence);
    stream.next(message.stamp);
  }
};
}  // namespace ros::serialization

namespace tactile_clay::nodes {

Chain::Chain(ros::NodeHandle nh, const std::vector<std::string>& topics) {
  for (const std::string& topic : topics) links_.push_back({topic, ros::Time(), ros::Subscriber()});
  // The first topic needs no subscription: it is known when its samples are sent.
  for (std::size_t i = 1; i < links_.size(); ++i)
    links_[i].subscriber = nh.subscribe<StampOnly>(
        links_[i].topic, 0,
        [this, i](const boost::shared_ptr<const StampOnly>& message) {
          const std::lock_guard<std::mutex> lock(mutex_);
          links_[i].newest = std::max(links_[i].newest, message->stamp);
        },
        ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

std::string Chain::whereIs(ros::Time stamp) const {
  std::vector<ros::Time> newest;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const Link& link : links_) newest.push_back(link.newest);
  }
  for (std::size_t i = 1; i < links_.size(); ++i) {
    if (newest[i] >= stamp) continue;
    const std::string& got = links_[i - 1].topic;
    const std::string& sent = links_[i].topic;
    const std::vector<std::string> nodes = publishersOf(sent);
    if (nodes.empty()) return "it arrived as " + got + ", and nobody publishes " + sent + " any more";
    std::string names = nodes.front();
    for (std::size_t k = 1; k < nodes.size(); ++k) names += " or " + nodes[k];
    return names + " got it as " + got + " and has not sent " + sent;
  }
  return "it passed all nodes";
}

}  // namespace tactile_clay::nodes
