// A nodelet manager whose exit code is not 0 if a nodelet failed; the stock manager always exits with 0.
#include <nodelet/loader.h>
#include <ros/ros.h>

#include <csignal>

#include "nodes/exit_code.h"
#include "nodes/freed_memory.h"
#include "nodes/signs_of_life.h"

int main(int argc, char** argv) {
  tactile_clay::nodes::keepFreedMemory();
  ros::init(argc, argv, "manager");
  std::signal(SIGTERM, [](int) { ros::requestShutdown(); });
  std::signal(SIGHUP, [](int) { ros::requestShutdown(); });
  {
    nodelet::Loader loader;
    tactile_clay::nodes::failWhenReplaced();
    ros::NodeHandle nh;
    const tactile_clay::nodes::SignsOfLife life(nh, ros::this_node::getName());
    ros::spin();
  }
  return tactile_clay::nodes::exitCode();
}
