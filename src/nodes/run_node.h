#pragma once

#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <csignal>
#include <exception>
#include <memory>

#include "nodes/exit_code.h"
#include "nodes/kept.h"

namespace tactile_clay::nodes {

/// Signs of life of a process, by the thread that serves its callbacks, while this lives.
inline ros::WallTimer signsOfLife(ros::NodeHandle& nh) {
  return nh.createWallTimer(ros::WallDuration(0.2), [](const ros::WallTimerEvent&) { beat(); });
}

/// Runs a node as the program `name` until it ends. \return the program's exit code; 1 after one line of
/// error
template <class Node>
int runNode(int argc, char** argv, const char* name) {
  ros::init(argc, argv, name);
  // roscpp handles SIGINT; an array must go silent on these as well.
  std::signal(SIGTERM, [](int) { ros::requestShutdown(); });
  std::signal(SIGHUP, [](int) { ros::requestShutdown(); });
  ros::NodeHandle nh, private_nh("~");  // outlive the catch: with the last handle goes the console
  failWhenReplaced();
  try {
    Node node(nh, private_nh);
    const ros::WallTimer life = signsOfLife(nh);
    ros::spin();
  } catch (const std::exception& error) {
    if (shuttingDown()) return exitCode();  // Ctrl-C at the start: parameters could not be read any more
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return exitCode();
}

/// A node as a nodelet. A node that cannot start ends its manager, as a required node ends its launch.
template <class Node>
class AsNodelet : public nodelet::Nodelet {
  void onInit() override {
    try {
      // The single-threaded handles: callbacks of one node never run at the same time, as in a program.
      node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      if (shuttingDown()) return;
      NODELET_FATAL("%s", error.what());
      finish(1);
    }
  }

  std::unique_ptr<Node> node_;
};

}  // namespace tactile_clay::nodes
