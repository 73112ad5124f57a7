#pragma once

#include <rviz/ogre_helpers/movable_text.h>
#include <rviz/ogre_helpers/shape.h>
#include <tactile_clay/ArrayState.h>
#include <tactile_clay/FocalPointArray.h>

#include <memory>
#include <vector>

#include "rviz_plugins/array_display.h"

namespace rviz {
class BoolProperty;
class ColorProperty;
class FloatProperty;
class RosTopicProperty;
}  // namespace rviz

namespace tactile_clay::rviz_plugins {

/// Focal points as spheres whose volume is proportional to the intensity, each on a thin beam from the array,
/// with its id and wanted pressure beside it. While `array/state` reports silence, they have a colour of
/// their own and no beams: they are wanted, and not played.
class FocalPointsDisplay : public ArrayDisplay<tactile_clay::FocalPointArray> {
  Q_OBJECT
 public:
  FocalPointsDisplay();
  ~FocalPointsDisplay() override;

  void update(float wall_dt, float ros_dt) override;

 protected:
  void subscribe() override;
  void unsubscribe() override;
  void reset() override;

 private Q_SLOTS:
  void redraw();
  void subscribeState();

 private:
  void processMessage(const tactile_clay::FocalPointArray::ConstPtr& message) override;

  tactile_clay::FocalPointArray::ConstPtr message_;
  ros::Subscriber state_subscriber_;
  bool is_silent_ = false;
  void clear();
  /// Makes the label of a point, above its sphere.
  /// @param diameter of the sphere, m
  void label(const tactile_clay::FocalPoint& point, float diameter);

  /// Text on a node of its own, above the point, and a line from the sphere up to a text that had to rise.
  struct Label {
    Ogre::SceneNode* node;
    std::unique_ptr<rviz::MovableText> text;
    std::unique_ptr<rviz::Shape> line;
    Ogre::Vector3 at;   // position of the point, m, in the frame of the array
    float lift, width;  // m: height above the point; width of the text
  };

  std::vector<std::unique_ptr<rviz::Shape>> shapes_;
  std::vector<Label> labels_;
  rviz::RosTopicProperty* state_topic_;
  rviz::FloatProperty* diameter_;
  rviz::ColorProperty* weak_;
  rviz::ColorProperty* strong_;
  rviz::ColorProperty* silent_;
  rviz::BoolProperty* through_;
  rviz::BoolProperty* beams_;
  rviz::BoolProperty* numbers_;
};

}  // namespace tactile_clay::rviz_plugins
