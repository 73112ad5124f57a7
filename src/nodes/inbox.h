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
/// As Receive, with the name of the node that published the message.
template <class M>
using ReceiveFrom = std::function<void(const boost::shared_ptr<const M>&, const std::string& publisher)>;
using Refuse = std::function<void(const std::string& reason)>;

/// Subscribes to a topic. A message in which `faultOf` finds a fault never reaches `receive`. An exception
/// that `receive` throws is caught: only this message is lost. In both cases `refuse` is called with the
/// reason, in one line without the topic. It must not throw.
template <class M>
ros::Subscriber subscribe(ros::NodeHandle nh, const std::string& topic, unsigned queue,
                          ReceiveFrom<M> receive, Refuse refuse) {
  using Event = ros::MessageEvent<M const>;
  const boost::function<void(const Event&)> guarded = [receive = std::move(receive),
                                                       refuse = std::move(refuse)](const Event& event) {
    std::string fault;
    try {
      const boost::shared_ptr<const M> message = event.getConstMessage();
      fault = faultOf(*message);
      if (fault.empty()) receive(message, event.getPublisherName());
    } catch (const std::exception& error) {
      fault = error.what();
    }
    if (!fault.empty()) refuse(fault);
  };
  return nh.subscribe<const Event&>(topic, queue, guarded, ros::VoidConstPtr(),
                                    ros::TransportHints().tcpNoDelay());
}

template <class M>
ros::Subscriber subscribe(ros::NodeHandle nh, const std::string& topic, unsigned queue, Receive<M> receive,
                          Refuse refuse) {
  ReceiveFrom<M> from = [receive = std::move(receive)](const auto& message, const std::string&) {
    receive(message);
  };
  return subscribe<M>(nh, topic, queue, std::move(from), std::move(refuse));
}

/// The subscriptions of a node, in which every message is checked. A refused message is logged in one
/// throttled line with topic and reason, and counted for diagnostics. May be used from several threads.
class Inbox {
 public:
  /// @param private_nh handle of the node; the lines begin with its name
  explicit Inbox(const ros::NodeHandle& private_nh);

  /// @param receive a Receive<M> or ReceiveFrom<M>
  /// @param also called for each message that is refused, with the reason
  template <class M, class R>
  ros::Subscriber subscribe(ros::NodeHandle nh, const std::string& topic, unsigned queue, R receive,
                            Refuse also = {}) {
    return nodes::subscribe<M>(
        nh, topic, queue, std::move(receive),
        [this, name = nh.resolveName(topic), also = std::move(also)](const std::string& reason) {
          refuse(name, reason);
          if (also) also(reason);
        });
  }

  /// Adds the messages that were refused since the last report: a warning, and a number per topic.
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  struct Topic {
    Throttle lines;
    unsigned refused = 0;  // since the last report
  };

  void refuse(const std::string& topic, const std::string& reason);

  std::string node_;
  std::mutex mutex_;
  std::map<std::string, Topic> topics_;  // topics on which a message was ever refused
};

}  // namespace tactile_clay::nodes
