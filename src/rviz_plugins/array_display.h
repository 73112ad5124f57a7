#pragma once

#include <OgreSceneNode.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/message_filter_display.h>
#include <std_msgs/Header.h>

#include "nodes/frame_name.h"

namespace tactile_clay::rviz_plugins {

/// A display of messages in the frame of an array.
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
};

}  // namespace tactile_clay::rviz_plugins
