#include "rviz_plugins/focal_points_display.h"

#include <OgreCamera.h>
#include <OgreEntity.h>
#include <OgreMaterial.h>
#include <OgreSceneManager.h>
#include <OgreSubEntity.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <pluginlib/class_list_macros.hpp>

#include "rviz_plugins/label_rows.h"
#include "rviz_plugins/shown_points.h"

namespace tactile_clay::rviz_plugins {
namespace {

// m, of a point of intensity 1: about the wavelength (8.6 mm), the width of the smallest focus. Larger balls
// hide the pressure on a fingertip.
constexpr float point_diameter = 0.010f;
constexpr float beam_diameter = 0.0015f;  // m
constexpr float beam_alpha = 0.35f;
constexpr float text_height = 0.008f;                        // m
constexpr float letter_width = 0.5f, row_height = 1.1f;      // of the height of the text
constexpr float line_diameter = 0.0006f, line_alpha = 0.5f;  // m; of the line from a point to its label
constexpr float nearest = 0.01f;                             // m from the camera
const Ogre::ColourValue text_color(0.1f, 0.1f, 0.1f);

/// Makes a cylinder a thin line from one place to another, in the frame of its parent.
void stretch(rviz::Shape& cylinder, float diameter, const Ogre::Vector3& from, const Ogre::Vector3& to) {
  cylinder.setPosition(0.5f * (from + to));
  cylinder.setOrientation(Ogre::Vector3::UNIT_Z.getRotationTo(to - from) *
                          Ogre::Quaternion(Ogre::Degree(90), Ogre::Vector3::UNIT_X));
  cylinder.setScale(Ogre::Vector3(diameter, (to - from).length(), diameter));
}

/// Draws a shape in front of everything: focal points lie between hand and clay, and both would hide them.
void showThrough(rviz::Shape& shape) {
  shape.getEntity()->getSubEntity(0)->getMaterial()->setDepthCheckEnabled(false);
  shape.getEntity()->getSubEntity(0)->getMaterial()->setDepthWriteEnabled(false);
  shape.getEntity()->setRenderQueueGroup(Ogre::RENDER_QUEUE_9);
}

}  // namespace

FocalPointsDisplay::FocalPointsDisplay() {
  state_topic_ = new rviz::RosTopicProperty(
      "State", "array/state",
      QString::fromStdString(ros::message_traits::datatype<tactile_clay::ArrayState>()),
      "Topic with the state of the array (tactile_clay/ArrayState): whether it sounds.", this,
      SLOT(subscribeState()));
  diameter_ = new rviz::FloatProperty("Diameter", point_diameter,
                                      "Diameter of a focal point of intensity 1, m.", this, SLOT(redraw()));
  diameter_->setMin(0.0f);
  weak_ =
      new rviz::ColorProperty("Weak", QColor(90, 200, 255), "Colour at intensity 0.", this, SLOT(redraw()));
  strong_ =
      new rviz::ColorProperty("Strong", QColor(255, 40, 120), "Colour at intensity 1.", this, SLOT(redraw()));
  silent_ = new rviz::ColorProperty("Silent", QColor(150, 150, 150), "Colour while the array is silent.",
                                    this, SLOT(redraw()));
  through_ = new rviz::BoolProperty("Show through", true,
                                    "If true, focal points are visible through hands and clay.", this,
                                    SLOT(redraw()));
  beams_ = new rviz::BoolProperty(
      "Beams", true, "A line from the centre of the array to each focal point, while the array sounds.", this,
      SLOT(redraw()));
  numbers_ = new rviz::BoolProperty("Numbers", true,
                                    "Id and wanted pressure beside each focal point, such as 3: 0.8 kPa.",
                                    this, SLOT(redraw()));
}

FocalPointsDisplay::~FocalPointsDisplay() {
  clear();
}

void FocalPointsDisplay::clear() {
  shapes_.clear();
  for (const Label& label : labels_) {
    label.node->detachAllObjects();
    scene_manager_->destroySceneNode(label.node);
  }
  labels_.clear();
}

void FocalPointsDisplay::subscribe() {
  ArrayDisplay::subscribe();
  subscribeState();
}

void FocalPointsDisplay::unsubscribe() {
  ArrayDisplay::unsubscribe();
  state_subscriber_.shutdown();
}

void FocalPointsDisplay::subscribeState() {
  is_silent_ = false;
  if (!isEnabled()) return;
  const auto take = [this](const tactile_clay::ArrayState::ConstPtr& state) {
    if (is_silent_ == !state->emitting) return;
    is_silent_ = !state->emitting;
    redraw();
  };
  if (subscribeBeside<tactile_clay::ArrayState>(*state_topic_, "State", state_subscriber_, take))
    setStatus(rviz::StatusProperty::Ok, "State", "subscribed");
}

void FocalPointsDisplay::reset() {
  ArrayDisplay::reset();
  is_silent_ = false;
  message_.reset();
  clear();
}

void FocalPointsDisplay::processMessage(const tactile_clay::FocalPointArray::ConstPtr& message) {
  message_ = message;
  redraw();
}

void FocalPointsDisplay::redraw() {
  clear();
  if (!message_) return;
  if (!place(message_->header)) return;
  for (const tactile_clay::FocalPoint& point : shownPoints(*message_)) {
    const Ogre::Vector3 at(static_cast<float>(point.position.x), static_cast<float>(point.position.y),
                           static_cast<float>(point.position.z));
    const float intensity = std::clamp(point.intensity, 0.0f, 1.0f);
    const Ogre::ColourValue color =
        is_silent_ ? silent_->getOgreColor()
                   : weak_->getOgreColor() * (1.0f - intensity) + strong_->getOgreColor() * intensity;
    auto sphere = std::make_unique<rviz::Shape>(rviz::Shape::Sphere, scene_manager_, scene_node_);
    sphere->setPosition(at);
    const float diameter = diameter_->getFloat() * std::cbrt(std::max(intensity, 0.02f));
    sphere->setScale(Ogre::Vector3(diameter));
    sphere->setColor(color.r, color.g, color.b, 1.0f);
    if (through_->getBool()) showThrough(*sphere);
    shapes_.push_back(std::move(sphere));
    if (numbers_->getBool()) label(point, diameter);
    if (!beams_->getBool() || is_silent_) continue;
    auto beam = std::make_unique<rviz::Shape>(rviz::Shape::Cylinder, scene_manager_, scene_node_);
    stretch(*beam, beam_diameter, Ogre::Vector3::ZERO, at);
    beam->setColor(color.r, color.g, color.b, beam_alpha);
    if (through_->getBool()) showThrough(*beam);
    shapes_.push_back(std::move(beam));
  }
}

/// Stacks the labels of points that the camera sees close together, with a line from each point to a label
/// that had to rise. This is done in every frame, because the camera moves.
void FocalPointsDisplay::update(float wall_dt, float ros_dt) {
  ArrayDisplay::update(wall_dt, ros_dt);
  const rviz::ViewController* view = context_->getViewManager()->getCurrent();
  if (view == nullptr || labels_.empty()) return;
  const Ogre::Camera& camera = *view->getCamera();
  const Ogre::Vector3 up = camera.getDerivedUp(), right = camera.getDerivedRight();
  std::vector<LabelBox> boxes, spheres;
  std::vector<float> depths;
  for (const Label& label : labels_) {
    const Ogre::Vector3 at = scene_node_->convertLocalToWorldPosition(label.at) - camera.getDerivedPosition();
    const bool flat = camera.getProjectionType() == Ogre::PT_ORTHOGRAPHIC;
    const float depth = flat ? 1.0f : std::max(at.dotProduct(camera.getDerivedDirection()), nearest);
    depths.push_back(depth);
    spheres.push_back({at.dotProduct(right) / depth, (at.dotProduct(up) - label.lift) / depth,
                       2.0f * label.lift / depth, 2.0f * label.lift / depth});
    boxes.push_back({at.dotProduct(right) / depth, (at.dotProduct(up) + label.lift) / depth,
                     label.width / depth, row_height * text_height / depth});
  }
  const std::vector<float> rises = risesOf(boxes, spheres);
  const Ogre::Vector3 upward = scene_node_->convertWorldToLocalDirection(up, false);
  for (std::size_t k = 0; k < labels_.size(); ++k) {
    const Label& label = labels_[k];
    const Ogre::Vector3 top = label.at + label.lift * upward;  // of the sphere
    label.node->setPosition(top + rises[k] * depths[k] * upward);
    const bool has_risen = rises[k] > 0.0f;
    label.line->getRootNode()->setVisible(has_risen);
    if (has_risen) stretch(*label.line, line_diameter, top, label.node->getPosition());
  }
}

void FocalPointsDisplay::label(const tactile_clay::FocalPoint& point, float diameter) {
  char words[48];
  std::snprintf(words, sizeof words, "%u: %.1f kPa", point.id, 1e-3 * static_cast<double>(point.pressure));
  Label label{scene_node_->createChildSceneNode(),
              std::make_unique<rviz::MovableText>(words, "Liberation Sans", text_height, text_color),
              std::make_unique<rviz::Shape>(rviz::Shape::Cylinder, scene_manager_, scene_node_),
              Ogre::Vector3(static_cast<float>(point.position.x), static_cast<float>(point.position.y),
                            static_cast<float>(point.position.z)),
              0.5f * diameter,
              letter_width * text_height * static_cast<float>(std::strlen(words))};
  label.text->setTextAlignment(rviz::MovableText::H_CENTER, rviz::MovableText::V_ABOVE);
  label.text->showOnTop(through_->getBool());
  label.line->setColor(text_color.r, text_color.g, text_color.b, line_alpha);
  if (through_->getBool()) showThrough(*label.line);
  label.line->getRootNode()->setVisible(false);  // until the label rises
  label.node->setPosition(label.at);
  label.node->attachObject(label.text.get());
  labels_.push_back(std::move(label));
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::FocalPointsDisplay, rviz::Display)
