#pragma once

#include <OgreSceneNode.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/message_filter_display.h>
#include <rviz/properties/ros_topic_property.h>
#include <std_msgs/Header.h>

#include <functional>

#include "nodes/frame_name.h"

namespace tactile_clay::rviz_plugins {

/// A display of messages in the frame of an array, or in another one that does not move.
template <class Message>
class ArrayDisplay : public rviz::MessageFilterDisplay<Message> {
 protected:
  /// Places the drawing at the pose of the array, and shows in the status whether this pose is known. The
  /// array does not move, so its latest pose also serves frames of recordings, whose stamps are old.
  bool place(const std_msgs::Header& header) {
    Ogre::Vector3 position;
    Ogre::Quaternion orientation;
    if (!this->context_->getFrameManager()->getTransform(nodes::frameName(header.frame_id), ros::Time(),
                                                         position, orientation)) {
      this->setStatusStd(rviz::StatusProperty::Error, "Transform", "no transform from " + header.frame_id);
      return false;
    }
    this->setStatus(rviz::StatusProperty::Ok, "Transform", "Transform OK");
    this->scene_node_->setPosition(position);
    this->scene_node_->setOrientation(orientation);
    return true;
  }

  /// Subscribes to a topic beside that of the display.
  /// @return false if it cannot be subscribed to: an error in the status `name`, and `subscriber` as it was
  template <class Other>
  bool subscribeBeside(const rviz::RosTopicProperty& topic, const QString& name, ros::Subscriber& subscriber,
                       const std::function<void(const typename Other::ConstPtr&)>& take) {
    try {
      subscriber = this->update_nh_.template subscribe<Other>(topic.getTopicStd(), 1, take);
      return true;
    } catch (const ros::Exception& error) {
      this->setStatus(rviz::StatusProperty::Error, name, error.what());
      return false;
    }
  }
};

}  // namespace tactile_clay::rviz_plugins
