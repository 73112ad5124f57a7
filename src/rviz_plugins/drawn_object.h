#pragma once

#include <OgreManualObject.h>
#include <OgreMaterial.h>
#include <OgreMaterialManager.h>
#include <OgreResourceGroupManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTechnique.h>

#include <string>

namespace tactile_clay::rviz_plugins {

/// Triangles of a display, and a material of their own without light: their colours contain it.
class DrawnObject {
 public:
  /// @param node to which the triangles belong
  /// @param what they are, for names in Ogre, which must differ
  DrawnObject(Ogre::SceneManager& scene, Ogre::SceneNode& node, const std::string& what)
      : scene_(scene), name_("tactile_clay " + what + " " + std::to_string(count_++)) {
    material_ = Ogre::MaterialManager::getSingleton().create(
        name_ + " material", Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
    pass().setLightingEnabled(false);
    object_ = scene_.createManualObject(name_);
    object_->setDynamic(true);
    node.attachObject(object_);
  }
  ~DrawnObject() {
    scene_.destroyManualObject(object_);
    Ogre::MaterialManager::getSingleton().remove(material_);
  }
  DrawnObject(const DrawnObject&) = delete;
  DrawnObject& operator=(const DrawnObject&) = delete;

  const std::string& name() const { return name_; }
  Ogre::Pass& pass() { return *material_->getTechnique(0)->getPass(0); }
  Ogre::ManualObject* operator->() { return object_; }
  /// Begins a list of triangles: ended by `end()` of the object.
  void begin() { object_->begin(material_->getName(), Ogre::RenderOperation::OT_TRIANGLE_LIST); }

 private:
  static inline int count_ = 0;

  Ogre::SceneManager& scene_;
  std::string name_;
  Ogre::MaterialPtr material_;
  Ogre::ManualObject* object_;
};

}  // namespace tactile_clay::rviz_plugins
