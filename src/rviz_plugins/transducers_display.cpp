#include "rviz_plugins/transducers_display.h"

#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>

#include <algorithm>
#include <cmath>
#include <pluginlib/class_list_macros.hpp>

namespace tactile_clay::rviz_plugins {
namespace {

constexpr float silent_grey = 0.2f;  // brightness of a transducer of amplitude 0
constexpr float lift = 0.001f;       // m, of the discs above the transducers

/// Red at phase 0, green at a third of the circle, blue at two thirds.
Ogre::ColourValue colorOf(float phase, float amplitude) {
  constexpr float circle = 2.0f * static_cast<float>(M_PI);
  const float turns = phase / circle;
  Ogre::ColourValue color;
  color.setHSB(turns - std::floor(turns), 0.85f, 1.0f);
  const float share = std::clamp(amplitude, 0.0f, 1.0f);
  return color * share + Ogre::ColourValue(silent_grey, silent_grey, silent_grey) * (1.0f - share);
}

}  // namespace

TransducersDisplay::TransducersDisplay() {
  geometry_topic_ = new rviz::RosTopicProperty(
      "Geometry", "array/geometry",
      QString::fromStdString(ros::message_traits::datatype<visualization_msgs::MarkerArray>()),
      "Topic with the positions of the transducers (visualization_msgs/MarkerArray with one SPHERE_LIST).",
      this, SLOT(subscribeGeometry()));
  size_ = new rviz::FloatProperty("Size", 0.008f, "Diameter of a transducer, m.", this, SLOT(redraw()));
  size_->setMin(0.0f);
}

TransducersDisplay::~TransducersDisplay() {
  if (cloud_) scene_node_->detachObject(cloud_.get());
}

void TransducersDisplay::onInitialize() {
  ArrayDisplay::onInitialize();
  cloud_ = std::make_unique<rviz::PointCloud>();
  cloud_->setRenderMode(rviz::PointCloud::RM_SPHERES);
  scene_node_->attachObject(cloud_.get());
}

void TransducersDisplay::subscribe() {
  ArrayDisplay::subscribe();
  subscribeGeometry();
}

void TransducersDisplay::unsubscribe() {
  ArrayDisplay::unsubscribe();
  geometry_subscriber_.shutdown();
}

void TransducersDisplay::reset() {
  ArrayDisplay::reset();
  drive_.reset();
  if (cloud_) cloud_->clear();
}

void TransducersDisplay::subscribeGeometry() {
  if (!isEnabled()) return;
  places_.clear();
  subscribeBeside<visualization_msgs::MarkerArray>(*geometry_topic_, "Geometry", geometry_subscriber_,
                                                   [this](const auto& markers) { takeGeometry(markers); });
}

void TransducersDisplay::takeGeometry(const visualization_msgs::MarkerArray::ConstPtr& markers) {
  for (const visualization_msgs::Marker& marker : markers->markers)
    if (marker.type == visualization_msgs::Marker::SPHERE_LIST) places_ = marker.points;
  redraw();
}

void TransducersDisplay::processMessage(const tactile_clay::ArrayDrive::ConstPtr& message) {
  drive_ = message;
  redraw();
}

void TransducersDisplay::redraw() {
  if (!cloud_) return;
  cloud_->clear();
  if (!drive_) return;
  if (drive_->phase.size() != places_.size() || drive_->amplitude.size() != places_.size()) {
    setStatus(rviz::StatusProperty::Error, "Geometry",
              QString("%1 phases for %2 transducers of %3")
                  .arg(drive_->phase.size())
                  .arg(places_.size())
                  .arg(geometry_topic_->getTopic()));
    return;
  }
  if (!place(drive_->header)) return;
  setStatus(rviz::StatusProperty::Ok, "Geometry", QString("%1 transducers").arg(places_.size()));
  std::vector<rviz::PointCloud::Point> points(places_.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!std::isfinite(drive_->phase[k] + drive_->amplitude[k])) continue;
    const geometry_msgs::Point& at = places_[k];
    points[k].position =
        Ogre::Vector3(static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z) + lift);
    points[k].color = colorOf(drive_->phase[k], drive_->amplitude[k]);
  }
  cloud_->setDimensions(size_->getFloat(), size_->getFloat(), size_->getFloat());
  cloud_->addPoints(points.data(), static_cast<uint32_t>(points.size()));
  context_->queueRender();
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::TransducersDisplay, rviz::Display)
