#include "nodes/node_programs.h"

#include <ros/ros.h>

#include <csignal>
#include <exception>
#include <map>
#include <memory>
#include <string>

#include "nodes/array_driver.h"
#include "nodes/clay_simulator.h"
#include "nodes/clay_surface.h"
#include "nodes/contact_pressure.h"
#include "nodes/exit_code.h"
#include "nodes/focal_point_renderer.h"
#include "nodes/freed_memory.h"
#include "nodes/hand_simulator.h"
#include "nodes/hand_skeleton.h"
#include "nodes/hand_surface.h"
#include "nodes/hand_tracking.h"
#include "nodes/rig_numbers.h"
#include "nodes/signs_of_life.h"
#include "nodes/simulated_array.h"

namespace tactile_clay::nodes {
namespace {

template <class Node>
std::shared_ptr<void> make(ros::NodeHandle& nh, ros::NodeHandle& private_nh) {
  return std::make_shared<Node>(nh, private_nh);
}

// Once for all programs: the headers of a node take a compiler ten seconds.
std::shared_ptr<void> makeNode(const char* name, ros::NodeHandle& nh, ros::NodeHandle& private_nh) {
  const std::map<std::string, decltype(&make<ClaySimulator>)> makers = {
      {"array_driver", make<ArrayDriver>},
      {"clay_simulator", make<ClaySimulator>},
      {"clay_surface", make<ClaySurface>},
      {"contact_pressure", make<ContactPressure>},
      {"focal_point_renderer", make<FocalPointRenderer>},
      {"hand_simulator", make<HandSimulator>},
      {"hand_skeleton", make<HandSkeleton>},
      {"hand_surface", make<HandSurface>},
      {"hand_tracking", make<HandTracking>},
      {"rig_numbers", make<RigNumbersNode>},
      {"simulated_array", make<SimulatedArray>}};
  return makers.at(name)(nh, private_nh);
}

}  // namespace

int runNode(const char* name, int argc, char** argv) {
  keepFreedMemory();
  ros::init(argc, argv, name);
  // roscpp handles SIGINT; an array must go silent on these signals as well.
  std::signal(SIGTERM, [](int) { ros::requestShutdown(); });
  std::signal(SIGHUP, [](int) { ros::requestShutdown(); });
  ros::NodeHandle nh, private_nh("~");  // outlive the catch: the log ends with the last handle
  failWhenReplaced();
  try {
    const SignsOfLife life(nh, private_nh.getNamespace());
    const std::shared_ptr<void> node = makeNode(name, nh, private_nh);
    ros::spin();
  } catch (const std::exception& error) {
    if (shuttingDown()) return exitCode();  // Ctrl-C at the start: parameters could no longer be read
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return exitCode();
}

}  // namespace tactile_clay::nodes
