#include "rviz_plugins/overlay.h"

#include <OgreHardwarePixelBuffer.h>
#include <OgreMaterialManager.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>
#include <OgreTextureManager.h>
#include <Overlay/OgreOverlay.h>
#include <Overlay/OgreOverlayManager.h>
#include <Overlay/OgrePanelOverlayElement.h>

#include <QPainter>
#include <cstring>

namespace tactile_clay::rviz_plugins {

Overlay::Overlay(const std::string& name) : name_(name) {
  Ogre::OverlayManager& manager = Ogre::OverlayManager::getSingleton();
  overlay_ = manager.create(name_);
  panel_ = static_cast<Ogre::PanelOverlayElement*>(manager.createOverlayElement("Panel", name_ + " panel"));
  panel_->setMetricsMode(Ogre::GMM_PIXELS);
  material_ = Ogre::MaterialManager::getSingleton().create(
      name_ + " material", Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
  Ogre::Pass* pass = material_->getTechnique(0)->getPass(0);
  pass->setLightingEnabled(false);
  pass->setDepthCheckEnabled(false);
  pass->setDepthWriteEnabled(false);
  pass->setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA);
  pass->createTextureUnitState();
  panel_->setMaterialName(material_->getName());
  overlay_->add2D(panel_);
}

Overlay::~Overlay() {
  Ogre::OverlayManager& manager = Ogre::OverlayManager::getSingleton();
  overlay_->hide();
  overlay_->remove2D(panel_);
  manager.destroyOverlayElement(panel_);
  manager.destroy(overlay_);
  Ogre::MaterialManager::getSingleton().remove(material_);
  if (texture_) Ogre::TextureManager::getSingleton().remove(texture_);
}

void Overlay::place(int x, int y) {
  x_ = x;
  y_ = y;
  const float width = panel_->getWidth(), height = panel_->getHeight();
  panel_->setHorizontalAlignment(x < 0 ? Ogre::GHA_RIGHT : Ogre::GHA_LEFT);
  panel_->setVerticalAlignment(y < 0 ? Ogre::GVA_BOTTOM : Ogre::GVA_TOP);
  panel_->setPosition(static_cast<float>(x) - (x < 0 ? width : 0.0f),
                      static_cast<float>(y) - (y < 0 ? height : 0.0f));
}

void Overlay::paint(int width, int height, const std::function<void(QPainter&)>& painter) {
  QImage image(width, height, QImage::Format_ARGB32);
  image.fill(Qt::transparent);
  {
    QPainter brush(&image);
    brush.setRenderHint(QPainter::Antialiasing);
    painter(brush);
  }
  if (!texture_ || static_cast<int>(texture_->getWidth()) != width ||
      static_cast<int>(texture_->getHeight()) != height) {
    if (texture_) Ogre::TextureManager::getSingleton().remove(texture_);
    texture_ = Ogre::TextureManager::getSingleton().createManual(
        name_ + " texture", material_->getGroup(), Ogre::TEX_TYPE_2D, static_cast<Ogre::uint>(width),
        static_cast<Ogre::uint>(height), 0, Ogre::PF_A8R8G8B8);
    material_->getTechnique(0)->getPass(0)->getTextureUnitState(0)->setTexture(texture_);
    panel_->setDimensions(static_cast<float>(width), static_cast<float>(height));
    place(x_, y_);
  }
  const Ogre::HardwarePixelBufferSharedPtr buffer = texture_->getBuffer();
  buffer->lock(Ogre::HardwareBuffer::HBL_DISCARD);
  const Ogre::PixelBox& box = buffer->getCurrentLock();
  for (int y = 0; y < height; ++y)
    std::memcpy(box.data + 4 * box.rowPitch * static_cast<std::size_t>(y), image.constScanLine(y),
                4 * static_cast<std::size_t>(width));
  buffer->unlock();
}

void Overlay::show(bool visible) {
  if (visible)
    overlay_->show();
  else
    overlay_->hide();
}

}  // namespace tactile_clay::rviz_plugins
