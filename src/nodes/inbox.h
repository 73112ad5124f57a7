#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>

#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "nodes/message_check.h"
#include "nodes/throttle.h"

namespace tactile_clay::nodes {

template <class M>
using Receive = std::function<void(const boost::shared_ptr<const M>&)>;
using Refuse = std::function<void(const std::string& reason)>;

/// Subscribes. A message that `faultOf` finds fault with never reaches `receive`; what `receive` throws ends
/// with the message. `refuse` is then told why, in one line without the topic, and must not throw.
template <class M>
ros::Subscriber subscribe(ros::NodeHandle nh, const std::string& topic, unsigned queue, Receive<M> receive,
                          Refuse refuse) {
  const boost::function<void(const boost::shared_ptr<const M>&)> guarded =
      [receive = std::move(receive), refuse = std::move(refuse)](const boost::shared_ptr<const M>& message) {
        std::string fault;
        try {
          fault = faultOf(*message);
          if (fault.empty()) receive(message);
        } catch (const std::exception& error) {
          fault = error.what();
        }
        if (!fault.empty()) refuse(fault);
      };
  return nh.subscribe<M>(topic, queue, guarded, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

/// The subscriptions of a node: the only way in for messages. What is refused is told in one throttled line
/// with topic and reason, and counted for diagnostics. May be used from several threads.
class Inbox {
 public:
  /// @param private_nh of the node, whose name the lines begin with
  explicit Inbox(const ros::NodeHandle& private_nh);

  /// @param also called for each message that is refused, with the line
  template <class M>
  ros::Subscriber subscribe(ros::NodeHandle nh, const std::string& topic, unsigned queue, Receive<M> receive,
                            Refuse also = {}) {
    return nodes::subscribe<M>(
        nh, topic, queue, std::move(receive),
        [this, name = nh.resolveName(topic), also = std::move(also)](const std::string& reason) {
          refuse(name, reason);
          if (also) also(reason);
        });
  }

  /// Adds what was refused since the last report: a warning, and a number for each topic.
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  struct Topic {
    Throttle lines;
    unsigned refused = 0;  // since the last report
  };

  void refuse(const std::string& topic, const std::string& reason);

  std::string node_;
  std::mutex mutex_;
  std::map<std::string, Topic> topics_;  // with something refused, ever
};

}  // namespace tactile_clay::nodes
