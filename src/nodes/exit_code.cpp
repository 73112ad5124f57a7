#include "nodes/exit_code.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>

#include <atomic>
#include <string>

namespace tactile_clay::nodes {
namespace {
std::atomic<int> code_of_process{0};
}

void finish(int code) {
  int before = code_of_process;
  while (before < code && !code_of_process.compare_exchange_weak(before, code)) {
  }
  ros::requestShutdown();
}

bool shuttingDown() {
  return !ros::ok() || ros::isShuttingDown();
}

void failWhenReplaced() {
  const auto& manager = ros::XMLRPCManager::instance();
  manager->unbind("shutdown");
  manager->bind("shutdown", [](XmlRpc::XmlRpcValue& call, XmlRpc::XmlRpcValue& result) {
    const bool told = call.getType() == XmlRpc::XmlRpcValue::TypeArray && call.size() > 1 &&
                      call[1].getType() == XmlRpc::XmlRpcValue::TypeString;
    const std::string reason = told ? static_cast<std::string>(call[1]) : "none is given";
    const bool replaced = reason.find("new node registered with same name") != std::string::npos;
    if (replaced)
      ROS_FATAL("another node took the name %s: this node ends", ros::this_node::getName().c_str());
    else
      ROS_WARN("Shutdown request received. Reason given for shutdown: [%s]", reason.c_str());
    finish(replaced ? 1 : 0);
    result = ros::xmlrpc::responseInt(1, "", 0);
  });
}

int exitCode() {
  return code_of_process;
}

}  // namespace tactile_clay::nodes
