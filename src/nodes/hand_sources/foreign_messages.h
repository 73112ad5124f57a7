#pragma once

#include <ros/ros.h>
#include <topic_tools/shape_shifter.h>

#include <string>
#include <utility>

#include "nodes/inbox.h"

namespace tactile_clay::nodes {

/// Like `subscribe`, but for messages of other programs, which may have another definition of M. With a plain
/// subscription their node would refuse the connection, and nothing would be reported. Here each such message
/// is refused with a line that has its type, its MD5 and its sender.
template <class M>
ros::Subscriber subscribeToOthers(ros::NodeHandle nh, const std::string& topic, ReceiveFrom<M> receive,
                                  Refuse refuse) {
  using Raw = topic_tools::ShapeShifter;
  using Event = ros::MessageEvent<Raw const>;
  const boost::function<void(const Event&)> guarded = [receive = std::move(receive),
                                                       refuse = std::move(refuse)](const Event& event) {
    const std::string type = ros::message_traits::DataType<M>::value(),
                      md5 = ros::message_traits::MD5Sum<M>::value();
    const Raw& raw = *event.getConstMessage();
    std::string fault;
    try {
      if (raw.getDataType() != type) {
        fault = event.getPublisherName() + " sends " + raw.getDataType() + ", expected " + type;
      } else if (raw.getMD5Sum() != md5) {
        fault = event.getPublisherName() + " sends another version of " + type + " (md5 " + raw.getMD5Sum() +
                ", expected " + md5 + ")";
      } else {
        const boost::shared_ptr<const M> message = raw.instantiate<M>();
        fault = faultOf(*message);
        if (fault.empty()) receive(message, event.getPublisherName());
      }
    } catch (const std::exception& error) {
      fault = error.what();
    }
    if (!fault.empty()) refuse(fault);
  };
  return nh.subscribe<const Event&>(topic, 1, guarded, ros::VoidConstPtr(),
                                    ros::TransportHints().tcpNoDelay());
}

}  // namespace tactile_clay::nodes
