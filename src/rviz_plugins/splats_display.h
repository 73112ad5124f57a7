#pragma once

#include <OgreRenderTargetListener.h>
#include <rviz/message_filter_display.h>
#include <sensor_msgs/PointCloud2.h>

#include <memory>

#include "rviz_plugins/splat_scene.h"
#include "surface/clay_splats.h"

namespace Ogre {
class RenderWindow;
}

namespace rviz {
class FloatProperty;
}

namespace tactile_clay::rviz_plugins {

/// The clay as a smooth surface, which the graphics card draws from the particles (class SplatScene). Only
/// the main view shows it; other views and the tools that select do not see it.
class SplatsDisplay : public rviz::MessageFilterDisplay<sensor_msgs::PointCloud2>,
                      public Ogre::RenderTargetListener {
  Q_OBJECT
 public:
  SplatsDisplay();
  ~SplatsDisplay() override;

 protected:
  void onInitialize() override;
  void onDisable() override;
  void reset() override;

 private Q_SLOTS:
  void redraw();

 private:
  void processMessage(const sensor_msgs::PointCloud2::ConstPtr& message) override;
  void preViewportUpdate(const Ogre::RenderTargetViewportEvent& event) override;
  void postViewportUpdate(const Ogre::RenderTargetViewportEvent& event) override;
  void refuse(const std::string& reason);

  rviz::FloatProperty* spacing_;
  std::unique_ptr<surface::ClaySplats> splats_;
  std::unique_ptr<SplatScene> scene_;  // null if the graphics card cannot draw it
  Ogre::RenderWindow* window_ = nullptr;
  sensor_msgs::PointCloud2::ConstPtr message_;
};

}  // namespace tactile_clay::rviz_plugins
