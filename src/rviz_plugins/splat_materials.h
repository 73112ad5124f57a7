#pragma once

#include <OgreHighLevelGpuProgram.h>
#include <OgreMaterial.h>
#include <OgrePass.h>
#include <OgreTexture.h>

#include <string>
#include <vector>

namespace tactile_clay::rviz_plugins {

/// The materials of SplatScene: programs of the graphics card, and what is written where.
class SplatMaterials {
 public:
  // Schemes of the viewports that draw the splats: the two techniques of `splats`.
  static const char *front_scheme, *field_scheme;

  /// What the graphics card or its driver lacks, in words; empty: nothing.
  static std::string lacking();

  /// @param name that no others have
  /// @throws std::runtime_error with one line where a program is refused
  explicit SplatMaterials(const std::string& name);
  ~SplatMaterials();
  SplatMaterials(const SplatMaterials&) = delete;
  SplatMaterials& operator=(const SplatMaterials&) = delete;

  const Ogre::MaterialPtr& splats() const { return splats_; }
  const Ogre::MaterialPtr& surface() const { return surface_; }

  /// @param front, field, colour what the passes before have drawn, each of width x height pixels
  void read(const Ogre::TexturePtr& front, const Ogre::TexturePtr& field, const Ogre::TexturePtr& colour);
  /// @param projection of the camera
  /// @param to_world its orientation in the fixed frame
  void setCamera(const Ogre::Matrix4& projection, const Ogre::Matrix4& to_world);
  /// @param spacing m, of the particles
  void setSpacing(float spacing);

 private:
  std::string program(const std::string& role, Ogre::GpuProgramType type, const char* source);
  void addSplatPass(Ogre::Pass& pass, const std::string& corner, const std::string& fragments, float bound);

  std::string name_;
  std::vector<Ogre::HighLevelGpuProgramPtr> programs_;
  Ogre::MaterialPtr splats_, surface_;
  Ogre::Pass *front_pass_ = nullptr, *field_pass_ = nullptr, *surface_pass_ = nullptr;
};

}  // namespace tactile_clay::rviz_plugins
