#pragma once

#include <OgreAxisAlignedBox.h>
#include <OgreMatrix4.h>
#include <OgreQuaternion.h>
#include <OgreTexture.h>
#include <OgreVector3.h>

#include <array>
#include <string>
#include <vector>

#include "rviz_plugins/splat_materials.h"
#include "surface/clay_splats.h"

namespace Ogre {
class Camera;
class ManualObject;
class MultiRenderTarget;
class RenderTexture;
class SceneManager;
class SceneNode;
class Viewport;
}  // namespace Ogre

namespace tactile_clay::rviz_plugins {

/// The clay by splatting ellipsoids (van der Laan et al. 2009, doi 10.1145/1507149.1507164, with the kernels
/// of Yu and Turk 2013). In a scene of its own, seen by the camera of the window, a first pass finds how far
/// the first ellipsoid is in each pixel. Where theirs smooths these depths, a second pass adds up there what
/// all kernels give: value and gradient of the field of the clay, and its colour. A rectangle in the window
/// then steps to where the field has the level of the surface, and gets light, colour and depth there: it
/// hides and is hidden like all else.
class SplatScene {
 public:
  /// @param shown the scene of the window
  /// @param name that no other one has
  /// @throws std::runtime_error with one line where the graphics card refuses
  SplatScene(Ogre::SceneManager& shown, const std::string& name);
  ~SplatScene();
  SplatScene(const SplatScene&) = delete;
  SplatScene& operator=(const SplatScene&) = delete;

  /// @param spacing m, of the particles
  void set(const std::vector<surface::Splat>& splats, double spacing);
  /// Pose of the splats in the fixed frame.
  void place(const Ogre::Vector3& position, const Ogre::Quaternion& orientation);

  /// Draws the splats as the camera of that viewport sees them, and shows them in the window until `hide`.
  void show(const Ogre::Viewport& viewport);
  void hide();

 private:
  void resize(unsigned width, unsigned height);
  void release();
  Ogre::RenderTexture* makeTexture(std::size_t k, unsigned width, unsigned height);
  void setRectangle(const Ogre::Matrix4& to_clip);

  std::string name_;
  Ogre::SceneManager &shown_, *own_;
  SplatMaterials materials_;
  Ogre::Camera* camera_;
  Ogre::SceneNode *splats_node_, *rectangle_node_;
  Ogre::ManualObject *splats_, *rectangle_;
  bool has_splats_ = false, has_rectangle_ = false;  // whether their sections were begun
  std::array<Ogre::TexturePtr, 3> textures_;         // front, field, colour
  Ogre::MultiRenderTarget* sums_ = nullptr;          // field and colour
  Ogre::AxisAlignedBox box_;                         // m, of the splats
};

}  // namespace tactile_clay::rviz_plugins
