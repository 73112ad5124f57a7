#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>

#include <functional>
#include <string>

namespace tactile_clay::nodes {

/// Publishes one status per second of a node on /diagnostics. Runs in the node's callback queue.
class Health {
 public:
  using Fill = std::function<void(diagnostic_updater::DiagnosticStatusWrapper&)>;

  Health(ros::NodeHandle nh, ros::NodeHandle private_nh, const std::string& what, Fill fill)
      : updater_(nh, private_nh, private_nh.getNamespace()) {
    updater_.setHardwareID("none");
    updater_.add(what, [fill = std::move(fill)](auto& status) { fill(status); });
    timer_ = nh.createWallTimer(ros::WallDuration(1.0),
                                [this](const ros::WallTimerEvent&) { updater_.force_update(); });
  }

 private:
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace tactile_clay::nodes
