#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <optional>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// Questions to a ROS master and to nodes by their XML-RPC address. They need no ros::init. Each ends within
/// two seconds, with an answer or without one, also if a process is frozen.

struct Address {
  std::string host;
  int port = 0;
};

/// The address in a text such as "http://host:port/".
/// @return nothing if the text has another form
std::optional<Address> addressOf(const std::string& uri);

/// Calls a method of a master or a node, and returns the value of the answer.
/// @param arguments after the name of the caller
/// @return nothing without an answer, or if it is an error
std::optional<XmlRpc::XmlRpcValue> ask(const Address& address, const std::string& method,
                                       const std::vector<std::string>& arguments = {});

/// A running node, in words: "/name (process 123 on host)".
struct RunningNode {
  std::string name, words;
};

/// The nodes of `names` (resolved names) that belong to a running process. A node that was killed is still
/// registered, but does not answer. A node that is frozen counts as running.
std::vector<RunningNode> running(const Address& master, const std::vector<std::string>& names);

/// As `running`, but nodes that are about to end have two seconds to do so.
std::vector<RunningNode> runningForGood(const Address& master, const std::vector<std::string>& names);

}  // namespace tactile_clay::nodes
