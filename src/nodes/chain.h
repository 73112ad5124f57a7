#pragma once

#include <ros/ros.h>

#include <mutex>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// Follows samples through the graph: of each topic that passes them on, the newest stamp that came by.
class Chain {
 public:
  /// @param topics in the order in which a sample passes them, by resolved name; the first is where it starts
  Chain(ros::NodeHandle nh, const std::vector<std::string>& topics);

  /// Which node got the sample and did not pass it on, in one line.
  std::string whereIs(ros::Time stamp) const;

 private:
  struct Link {
    std::string topic;
    ros::Time newest;
    ros::Subscriber subscriber;
  };

  mutable std::mutex mutex_;
  std::vector<Link> links_;
};

}  // namespace tactile_clay::nodes
