#include "rviz_plugins/splat_scene.h"

#include <OgreCamera.h>
#include <OgreHardwarePixelBuffer.h>
#include <OgreManualObject.h>
#include <OgreRenderSystem.h>
#include <OgreRenderTexture.h>
#include <OgreResourceGroupManager.h>
#include <OgreRoot.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTextureManager.h>
#include <OgreViewport.h>

#include <algorithm>
#include <string>
#include <utility>

namespace tactile_clay::rviz_plugins {
namespace {

constexpr const char* kind_of_scene = "DefaultSceneManager";
constexpr Ogre::PixelFormat format = Ogre::PF_FLOAT32_RGBA;

Ogre::RenderTexture* targetOf(const Ogre::TexturePtr& texture) {
  return texture->getBuffer()->getRenderTarget();
}

/// Begins the only section of an object anew.
void restart(Ogre::ManualObject& object, bool& begun, const Ogre::MaterialPtr& material,
             std::size_t vertices) {
  object.estimateVertexCount(vertices);
  if (begun)
    object.beginUpdate(0);
  else
    object.begin(material->getName(), Ogre::RenderOperation::OT_TRIANGLE_LIST);
  begun = true;
}

void addViewport(Ogre::RenderTarget& target, Ogre::Camera* camera, const char* scheme) {
  Ogre::Viewport* viewport = target.addViewport(camera);
  viewport->setMaterialScheme(scheme);
  viewport->setBackgroundColour(Ogre::ColourValue(0.0f, 0.0f, 0.0f, 0.0f));
  viewport->setOverlaysEnabled(false);
  viewport->setShadowsEnabled(false);
  viewport->setSkiesEnabled(false);
  target.setAutoUpdated(false);
}

}  // namespace

SplatScene::SplatScene(Ogre::SceneManager& shown, const std::string& name)
    : name_(name), shown_(shown), own_(nullptr), materials_(name) {
  own_ = Ogre::Root::getSingleton().createSceneManager(kind_of_scene, name + " scene");
  camera_ = own_->createCamera(name + " camera");
  splats_ = own_->createManualObject(name + " splats");
  splats_->setDynamic(true);
  splats_node_ = own_->getRootSceneNode()->createChildSceneNode();
  splats_node_->attachObject(splats_);
  rectangle_ = shown_.createManualObject(name + " rectangle");
  rectangle_->setDynamic(true);
  rectangle_node_ = shown_.getRootSceneNode()->createChildSceneNode();
  rectangle_node_->attachObject(rectangle_);
  hide();
}

SplatScene::~SplatScene() {
  release();
  rectangle_node_->detachAllObjects();
  shown_.destroyManualObject(rectangle_);
  shown_.destroySceneNode(rectangle_node_);
  Ogre::Root::getSingleton().destroySceneManager(own_);  // with all that is in it
}

void SplatScene::release() {
  if (sums_ != nullptr) Ogre::Root::getSingleton().getRenderSystem()->destroyRenderTarget(sums_->getName());
  sums_ = nullptr;
  for (Ogre::TexturePtr& texture : textures_) {
    if (!texture) continue;
    Ogre::TextureManager::getSingleton().remove(texture->getHandle());
    texture = Ogre::TexturePtr();
  }
}

Ogre::RenderTexture* SplatScene::makeTexture(std::size_t k, unsigned width, unsigned height) {
  textures_[k] = Ogre::TextureManager::getSingleton().createManual(
      name_ + " texture " + std::to_string(k), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
      Ogre::TEX_TYPE_2D, width, height, 0, format, Ogre::TU_RENDERTARGET);
  return targetOf(textures_[k]);
}

void SplatScene::resize(unsigned width, unsigned height) {
  if (textures_[0] && textures_[0]->getWidth() == width && textures_[0]->getHeight() == height) return;
  release();
  addViewport(*makeTexture(0, width, height), camera_, SplatMaterials::front_scheme);
  sums_ = Ogre::Root::getSingleton().getRenderSystem()->createMultiRenderTarget(name_ + " sums");
  for (std::size_t k = 1; k < textures_.size(); ++k) {
    Ogre::RenderTexture* target = makeTexture(k, width, height);
    target->setAutoUpdated(false);
    sums_->bindSurface(k - 1, target);
  }
  addViewport(*sums_, camera_, SplatMaterials::field_scheme);
  materials_.read(textures_[0], textures_[1], textures_[2]);
}

void SplatScene::set(const std::vector<surface::Splat>& splats, double spacing) {
  box_.setNull();
  materials_.setSpacing(static_cast<float>(spacing));
  if (splats.empty()) return;
  restart(*splats_, has_splats_, materials_.splats(), 4 * splats.size());
  Ogre::uint32 first = 0;
  for (const surface::Splat& splat : splats) {
    const surface::EllipsoidKernel& kernel = splat.kernel;
    const Eigen::Vector3f &c = kernel.centre, &color = splat.color;
    const Eigen::Matrix3f& s = kernel.shape;
    for (const auto& [right, up] : {std::pair(-1.0f, -1.0f), {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
      splats_->position(c.x(), c.y(), c.z());
      splats_->textureCoord(right, up, kernel.weight);
      splats_->textureCoord(s(0, 0), s(0, 1), s(0, 2));
      splats_->textureCoord(s(1, 1), s(1, 2), s(2, 2));
      splats_->textureCoord(color.x(), color.y(), color.z());
    }
    splats_->quad(first, first + 1, first + 2, first + 3);
    first += 4;
    for (const float side : {-1.0f, 1.0f}) {
      const Eigen::Vector3f corner = c + side * kernel.reach;
      box_.merge(Ogre::Vector3(corner.x(), corner.y(), corner.z()));
    }
  }
  splats_->end();
  splats_->setBoundingBox(Ogre::AxisAlignedBox::BOX_INFINITE);
}

void SplatScene::place(const Ogre::Vector3& position, const Ogre::Quaternion& orientation) {
  splats_node_->setPosition(position);
  splats_node_->setOrientation(orientation);
}

/// Sets the rectangle to the part of the window in which the splats are, or to all of it if some are behind
/// the camera.
void SplatScene::setRectangle(const Ogre::Matrix4& to_clip) {
  float left = 1.0f, right = -1.0f, bottom = 1.0f, top = -1.0f;
  for (unsigned k = 0; k < 8; ++k) {
    const Ogre::Vector4 at =
        to_clip * Ogre::Vector4((k & 1u ? box_.getMaximum() : box_.getMinimum()).x,
                                (k & 2u ? box_.getMaximum() : box_.getMinimum()).y,
                                (k & 4u ? box_.getMaximum() : box_.getMinimum()).z, 1.0f);
    if (!(at.w > 0.0f)) {
      left = bottom = -1.0f;
      right = top = 1.0f;
      break;
    }
    left = std::min(left, at.x / at.w);
    right = std::max(right, at.x / at.w);
    bottom = std::min(bottom, at.y / at.w);
    top = std::max(top, at.y / at.w);
  }
  restart(*rectangle_, has_rectangle_, materials_.surface(), 4);
  rectangle_->position(std::max(left, -1.0f), std::max(bottom, -1.0f), 0.0f);
  rectangle_->position(std::min(right, 1.0f), std::max(bottom, -1.0f), 0.0f);
  rectangle_->position(std::min(right, 1.0f), std::min(top, 1.0f), 0.0f);
  rectangle_->position(std::max(left, -1.0f), std::min(top, 1.0f), 0.0f);
  rectangle_->quad(0, 1, 2, 3);
  rectangle_->end();
  rectangle_->setBoundingBox(Ogre::AxisAlignedBox::BOX_INFINITE);
}

void SplatScene::show(const Ogre::Viewport& viewport) {
  if (box_.isNull()) return;
  const Ogre::Camera& camera = *viewport.getCamera();
  resize(static_cast<unsigned>(viewport.getActualWidth()), static_cast<unsigned>(viewport.getActualHeight()));
  camera_->setCustomViewMatrix(true, camera.getViewMatrix());
  camera_->setCustomProjectionMatrix(true, camera.getProjectionMatrix());
  materials_.setCamera(camera.getProjectionMatrix(), Ogre::Matrix4(camera.getDerivedOrientation()));
  targetOf(textures_[0])->update();
  sums_->update();
  setRectangle(camera.getProjectionMatrix() * camera.getViewMatrix() * splats_node_->_getFullTransform());
  rectangle_->setVisible(true);
}

void SplatScene::hide() {
  rectangle_->setVisible(false);
}

}  // namespace tactile_clay::rviz_plugins
