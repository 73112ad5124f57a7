#pragma once

#include <ros/ros.h>
#include <rviz/display.h>
#include <tactile_clay/ArrayState.h>
#include <tactile_clay/ClayStatus.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "rviz_plugins/overlay.h"

namespace rviz {
class FloatProperty;
class IntProperty;
class RosTopicProperty;
}  // namespace rviz

namespace tactile_clay::rviz_plugins {

/// The state of the rig in words over the window: the clay and whether it keeps real time, the latency from
/// hand to array, whether the array sounds, and why it is silent.
class RigStateDisplay : public rviz::Display {
  Q_OBJECT
 public:
  RigStateDisplay();
  ~RigStateDisplay() override;

  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void subscribe();

 private:
  struct Line {
    std::string text;
    int level = 0;  // 0 good, 1 worth a look, 2 no messages come
  };
  std::vector<Line> lines() const;

  std::unique_ptr<Overlay> overlay_;
  rviz::RosTopicProperty* clay_topic_;
  rviz::RosTopicProperty* array_topic_;
  rviz::IntProperty* size_;
  ros::Subscriber clay_subscriber_, array_subscriber_;  // their callbacks run in the thread that draws
  tactile_clay::ClayStatus::ConstPtr clay_;
  tactile_clay::ArrayState::ConstPtr array_;
  ros::SteadyTime clay_came_, array_came_;
  float since_drawn_ = 0.0f;  // s
  std::string drawn_;
};

}  // namespace tactile_clay::rviz_plugins
