#pragma once

#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <csignal>
#include <exception>
#include <memory>
#include <string>

#include "nodes/exit_code.h"
#include "nodes/freed_memory.h"
#include "nodes/kept.h"

namespace tactile_clay::nodes {

constexpr double sign_of_life_period = 0.2;  // s
// s, shorter than the patience of keep_running, so that the log has the name of the silent node before the
// process is ended.
constexpr double silence_to_tell = 2.0;

/// Gives signs of life of a node, from the thread that serves its callbacks, while this object lives.
class SignsOfLife {
 public:
  /// @param nh handle of the queue with the callbacks
  /// @param node its full name
  SignsOfLife(const ros::NodeHandle& nh, const std::string& node)
      : node_(node),
        timer_(nh.createWallTimer(ros::WallDuration(sign_of_life_period), [node](const ros::WallTimerEvent&) {
          beat(node);
          const std::string silent = silentFor(silence_to_tell);
          if (!silent.empty())
            ROS_WARN_THROTTLE(5.0, "no sign of life for %.0f s from %s", silence_to_tell, silent.c_str());
        })) {}
  ~SignsOfLife() {
    timer_.stop();
    endOfLife(node_);
  }
  SignsOfLife(const SignsOfLife&) = delete;
  SignsOfLife& operator=(const SignsOfLife&) = delete;

 private:
  std::string node_;
  ros::WallTimer timer_;
};

/// Runs a node as the program `name` until it ends.
/// @return the program's exit code; 1 after one line of error
template <class Node>
int runNode(int argc, char** argv, const char* name) {
  keepFreedMemory();
  ros::init(argc, argv, name);
  // roscpp handles SIGINT; an array must go silent on these signals as well.
  std::signal(SIGTERM, [](int) { ros::requestShutdown(); });
  std::signal(SIGHUP, [](int) { ros::requestShutdown(); });
  ros::NodeHandle nh, private_nh("~");  // outlive the catch: the log ends with the last handle
  failWhenReplaced();
  try {
    const SignsOfLife life(nh, private_nh.getNamespace());
    Node node(nh, private_nh);
    ros::spin();
  } catch (const std::exception& error) {
    if (shuttingDown()) return exitCode();  // Ctrl-C at the start: parameters could no longer be read
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
      life_ = std::make_unique<SignsOfLife>(getNodeHandle(), getPrivateNodeHandle().getNamespace());
    } catch (const std::exception& error) {
      if (shuttingDown()) return;
      NODELET_FATAL("%s", error.what());
      finish(1);
    }
  }

  std::unique_ptr<SignsOfLife> life_;
  std::unique_ptr<Node> node_;  // destroyed first: it may give signs of life by itself
};

}  // namespace tactile_clay::nodes
