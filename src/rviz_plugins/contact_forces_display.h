#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <memory>
#include <vector>

#include "rviz_plugins/array_display.h"
#include "rviz_plugins/drawn_object.h"
#include "rviz_plugins/force_arrows.h"

namespace rviz {
class BoolProperty;
class ColorProperty;
class EnumProperty;
class FloatProperty;
}  // namespace rviz

namespace tactile_clay::rviz_plugins {

/// Arrows for the forces of `clay/contacts`: of the hands on the clay, or of the clay on the skin. The tip of
/// an arrow is at the contact. Its length is in proportion to the force.
class ContactForcesDisplay : public ArrayDisplay<sensor_msgs::PointCloud2> {
  Q_OBJECT
 public:
  ContactForcesDisplay();
  ~ContactForcesDisplay() override;

 protected:
  void onInitialize() override;
  void reset() override;

 private Q_SLOTS:
  void redraw();

 private:
  void processMessage(const sensor_msgs::PointCloud2::ConstPtr& message) override;
  std::vector<PlacedForce> forces() const;
  void draw(std::vector<PlacedForce> arrows);

  rviz::EnumProperty* on_;
  rviz::FloatProperty *length_, *thickness_, *cell_;
  rviz::ColorProperty* color_;
  rviz::BoolProperty* through_;
  sensor_msgs::PointCloud2::ConstPtr message_;
  std::unique_ptr<DrawnObject> arrows_;
};

}  // namespace tactile_clay::rviz_plugins
