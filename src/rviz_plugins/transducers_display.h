#pragma once

#include <ros/ros.h>
#include <rviz/ogre_helpers/point_cloud.h>
#include <tactile_clay/ArrayDrive.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <vector>

#include "rviz_plugins/array_display.h"

namespace rviz {
class FloatProperty;
class RosTopicProperty;
}  // namespace rviz

namespace tactile_clay::rviz_plugins {

/// The transducers of the array, each with the colour of its phase, as bright as its amplitude; dark if
/// silent.
class TransducersDisplay : public ArrayDisplay<tactile_clay::ArrayDrive> {
  Q_OBJECT
 public:
  TransducersDisplay();
  ~TransducersDisplay() override;

 protected:
  void onInitialize() override;
  void subscribe() override;
  void unsubscribe() override;
  void reset() override;

 private Q_SLOTS:
  void redraw();
  void subscribeGeometry();

 private:
  void processMessage(const tactile_clay::ArrayDrive::ConstPtr& message) override;
  void takeGeometry(const visualization_msgs::MarkerArray::ConstPtr& markers);

  rviz::RosTopicProperty* geometry_topic_;
  rviz::FloatProperty* size_;
  ros::Subscriber geometry_subscriber_;  // its callback runs in the thread that draws
  std::vector<geometry_msgs::Point> places_;
  tactile_clay::ArrayDrive::ConstPtr drive_;
  std::unique_ptr<rviz::PointCloud> cloud_;
};

}  // namespace tactile_clay::rviz_plugins
