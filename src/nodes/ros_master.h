#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <optional>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// Questions to a ROS master and to nodes by their XML-RPC address. They need no ros::init, and each has an
/// answer or none within two seconds, also where a process is frozen.

struct Address {
  std::string host;
  int port = 0;
};

/// Of "http://host:port/".
/// @return nothing where it is none
std::optional<Address> addressOf(const std::string& uri);

/// The value of a call to a master or a node that went well.
/// @param arguments after the name of the caller
/// @return nothing without an answer, or where it is an error
std::optional<XmlRpc::XmlRpcValue> ask(const Address& address, const std::string& method,
                                       const std::vector<std::string>& arguments = {});

/// A running node, in words: "/name (process 123 on host)".
struct RunningNode {
  std::string name, words;
};

/// Those of `names`, which are resolved names, that belong to a running process. A node that was killed is
/// still registered, but does not answer; one that is frozen runs.
std::vector<RunningNode> running(const Address& master, const std::vector<std::string>& names);

/// As `running`, but nodes that are about to end have two seconds to do so.
std::vector<RunningNode> runningForGood(const Address& master, const std::vector<std::string>& names);

}  // namespace tactile_clay::nodes
