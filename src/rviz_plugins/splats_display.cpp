#include "rviz_plugins/splats_display.h"

#include <OgreRenderWindow.h>
#include <OgreSceneNode.h>
#include <ros/console.h>
#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/properties/float_property.h>
#include <rviz/render_panel.h>
#include <rviz/view_manager.h>

#include <pluginlib/class_list_macros.hpp>

#include "nodes/frame_name.h"
#include "nodes/surface_markers.h"

namespace tactile_clay::rviz_plugins {
namespace {

constexpr const char* instead = "Switch on the display 'Clay' or 'Clay as balls' instead.";

std::string newSceneName() {
  static unsigned count = 0;
  return "tactile_clay splats " + std::to_string(count++);
}

}  // namespace

SplatsDisplay::SplatsDisplay() {
  spacing_ = new rviz::FloatProperty("Spacing", 0.005f,
                                     "Distance between particles at rest, m: `spacing` of the scene file.",
                                     this, SLOT(redraw()));
  spacing_->setMin(0.001f);
  spacing_->setMax(0.02f);
}

SplatsDisplay::~SplatsDisplay() {
  if (window_ != nullptr) window_->removeListener(this);
}

void SplatsDisplay::onInitialize() {
  MessageFilterDisplay::onInitialize();
  if (const std::string lacks = SplatMaterials::lacking(); !lacks.empty()) {
    refuse("the graphics card or its driver lacks " + lacks);
    return;
  }
  try {
    scene_ = std::make_unique<SplatScene>(*scene_manager_, newSceneName());
  } catch (const std::exception& error) {
    refuse(error.what());
    return;
  }
  window_ = context_->getViewManager()->getRenderPanel()->getRenderWindow();
  window_->addListener(this);
  setStatus(rviz::StatusProperty::Ok, "Shaders", "OK");
}

void SplatsDisplay::refuse(const std::string& reason) {
  const std::string line = reason + ". " + instead;
  setStatusStd(rviz::StatusProperty::Error, "Shaders", line);
  ROS_WARN("%s: %s", getNameStd().c_str(), line.c_str());
}

void SplatsDisplay::onDisable() {
  MessageFilterDisplay::onDisable();
  if (scene_) scene_->hide();
}

void SplatsDisplay::reset() {
  MessageFilterDisplay::reset();
  message_.reset();
  if (scene_) scene_->set({}, static_cast<double>(spacing_->getFloat()));
}

void SplatsDisplay::processMessage(const sensor_msgs::PointCloud2::ConstPtr& message) {
  message_ = message;
  redraw();
}

void SplatsDisplay::redraw() {
  if (!scene_ || !message_) return;
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  const std::string frame = nodes::frameName(message_->header.frame_id);
  if (!context_->getFrameManager()->getTransform(frame, message_->header.stamp, position, orientation)) {
    setStatusStd(rviz::StatusProperty::Error, "Transform", "no transform from " + frame);
    return;
  }
  setStatus(rviz::StatusProperty::Ok, "Transform", "Transform OK");
  try {
    const auto spacing = static_cast<double>(spacing_->getFloat());
    if (!splats_ || splats_->spacing() != spacing) splats_ = std::make_unique<surface::ClaySplats>(spacing);
    const nodes::SurfaceParticles particles = nodes::surfaceParticles(*message_);
    const std::vector<surface::Splat> splats = splats_->update(particles.position, particles.color);
    scene_->place(position, orientation);
    scene_->set(splats, spacing);
    setStatus(rviz::StatusProperty::Ok, "Particles",
              QString("%1 particles, of which %2 are drawn").arg(particles.color.size()).arg(splats.size()));
  } catch (const std::exception& error) {
    scene_->set({}, 1.0);
    setStatusStd(rviz::StatusProperty::Error, "Particles", error.what());
  }
  context_->queueRender();
}

void SplatsDisplay::preViewportUpdate(const Ogre::RenderTargetViewportEvent& event) {
  if (isEnabled()) scene_->show(*event.source);
}

void SplatsDisplay::postViewportUpdate(const Ogre::RenderTargetViewportEvent& /*event*/) {
  scene_->hide();
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::SplatsDisplay, rviz::Display)
