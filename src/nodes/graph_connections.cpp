#include "nodes/graph_connections.h"

#include <ros/master.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>
#include <map>
#include <set>

#include "nodes/ros_master.h"

namespace tactile_clay::nodes {
namespace {

using XmlRpc::XmlRpcValue;
using Nodes = std::set<std::string>;

std::map<std::string, Nodes> nodesByTopic(XmlRpcValue& list) {
  std::map<std::string, Nodes> nodes;
  for (int i = 0; i < list.size(); ++i)
    for (int k = 0; k < list[i][1].size(); ++k)
      nodes[list[i][0]].insert(static_cast<std::string>(list[i][1][k]));
  return nodes;
}

/// Subscribers of `topic` to which the node `publisher` reports a connection.
Nodes connectedTo(const std::string& publisher, const std::string& topic) {
  XmlRpcValue request, response, uri;
  request[0] = ros::this_node::getName();
  request[1] = publisher;
  Nodes connected;
  if (!ros::master::execute("lookupNode", request, response, uri, false)) return connected;
  const auto address = addressOf(static_cast<std::string>(uri));
  auto info = address ? ask(*address, "getBusInfo") : std::nullopt;  // no answer from a frozen node
  if (!info || info->getType() != XmlRpcValue::TypeArray) return connected;
  XmlRpcValue& links = *info;
  for (int i = 0; i < links.size(); ++i)
    if (links[i].size() >= 5 && static_cast<std::string>(links[i][2]) == "o" &&
        static_cast<std::string>(links[i][4]) == topic)
      connected.insert(static_cast<std::string>(links[i][1]));
  return connected;
}

using NodesByTopic = std::map<std::string, Nodes>;

std::string missingLink(const std::string& topic, const Nodes& publishers, const Nodes& subscribers) {
  if (subscribers.empty()) return "";
  for (const std::string& publisher : publishers) {
    const Nodes connected = connectedTo(publisher, topic);
    for (const std::string& subscriber : subscribers)
      if (connected.count(subscriber) == 0)
        return publisher + " is not yet connected to " + subscriber + " on " + topic;
  }
  return "";
}

}  // namespace

std::string missingConnection(const Connections& wanted) {
  XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false))
    return "the master does not answer";
  NodesByTopic publishers = nodesByTopic(state[0]), subscribers = nodesByTopic(state[1]);
  for (const std::string& topic : wanted.required) {
    if (publishers[topic].empty()) return "nobody publishes " + topic;
    if (subscribers[topic].empty()) return "nobody subscribes to " + topic;
    const bool left_out =
        std::find(wanted.unrecorded.begin(), wanted.unrecorded.end(), topic) != wanted.unrecorded.end();
    if (!wanted.recorder.empty() && !left_out && subscribers[topic].count(wanted.recorder) == 0)
      return wanted.recorder + " does not record " + topic;
  }
  for (const auto* topics : {&wanted.required, &wanted.optional})
    for (const std::string& topic : *topics) {
      std::string missing = missingLink(topic, publishers[topic], subscribers[topic]);
      if (!missing.empty()) return missing;
    }
  return "";
}

std::vector<std::string> publishersOf(const std::string& topic) {
  XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return {};
  const Nodes nodes = nodesByTopic(state[0])[topic];
  return {nodes.begin(), nodes.end()};
}

}  // namespace tactile_clay::nodes
