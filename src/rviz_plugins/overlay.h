#pragma once

#include <OgreMaterial.h>
#include <OgreTexture.h>

#include <QImage>
#include <functional>
#include <string>

class QPainter;

namespace Ogre {
class Overlay;
class PanelOverlayElement;
}  // namespace Ogre

namespace tactile_clay::rviz_plugins {

/// A picture that lies over the window of rviz, at a fixed place.
class Overlay {
 public:
  /// @param name that no other overlay has
  explicit Overlay(const std::string& name);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  /// @param x, y pixels from the left and the top of the window; from its right and bottom where negative
  void place(int x, int y);
  /// Paints the picture anew, on a transparent ground.
  /// @param width, height pixels
  void paint(int width, int height, const std::function<void(QPainter&)>& painter);
  void show(bool visible);

 private:
  std::string name_;
  int x_ = 0, y_ = 0;
  Ogre::Overlay* overlay_;
  Ogre::PanelOverlayElement* panel_;
  Ogre::MaterialPtr material_;
  Ogre::TexturePtr texture_;
};

}  // namespace tactile_clay::rviz_plugins
