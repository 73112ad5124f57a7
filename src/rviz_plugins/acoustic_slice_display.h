#pragma once

#include <ros/ros.h>
#include <rviz/message_filter_display.h>
#include <tactile_clay/ArrayDrive.h>
#include <tactile_clay/FocalPointArray.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <vector>

#include "nodes/played_drives.h"
#include "rviz_plugins/array_display.h"
#include "rviz_plugins/drawn_object.h"
#include "rviz_plugins/overlay.h"
#include "ultrasound/array_layout.h"

namespace rviz {
class BoolProperty;
class EnumProperty;
class FloatProperty;
class RosTopicProperty;
}  // namespace rviz

namespace tactile_clay::rviz_plugins {

/// A slice of the acoustic field of an array: the exact sum over its transducers, with the drives of
/// `array/drive`, and a colour bar in Pa or dB. It computes only while it is shown.
class AcousticSliceDisplay : public ArrayDisplay<tactile_clay::ArrayDrive> {
  Q_OBJECT
 public:
  AcousticSliceDisplay();
  ~AcousticSliceDisplay() override;

  void update(float wall_dt, float ros_dt) override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;
  void subscribe() override;
  void unsubscribe() override;
  void reset() override;

 private Q_SLOTS:
  void changed();
  void subscribeOthers();

 private:
  /// Points of the slice, row by row, m, in the frame of the array.
  struct Grid {
    int columns = 0, rows = 0;
    std::vector<Eigen::Vector3f> points;
  };

  void processMessage(const tactile_clay::ArrayDrive::ConstPtr& message) override;
  Grid grid() const;
  void draw();
  void drawBar(float full_scale);

  rviz::RosTopicProperty *geometry_topic_, *points_topic_;
  rviz::EnumProperty *plane_, *unit_;
  rviz::BoolProperty* follow_;
  rviz::FloatProperty *position_, *size_, *step_, *full_scale_, *range_, *alpha_, *rate_;
  ros::Subscriber geometry_subscriber_, points_subscriber_;  // their callbacks run in the thread that draws
  ultrasound::ArrayLayout layout_;
  nodes::PlayedDrives played_;
  std_msgs::Header header_;  // header of the newest drive
  tactile_clay::FocalPointArray::ConstPtr points_;
  std::unique_ptr<DrawnObject> slice_;
  std::unique_ptr<Overlay> bar_;
  std::string bar_drawn_;
  bool news_ = false;
  float since_drawn_ = 1e9f;  // s
};

}  // namespace tactile_clay::rviz_plugins
