#include "rviz_plugins/splat_materials.h"

#include <OgreGpuProgramManager.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgreMaterialManager.h>
#include <OgreRenderSystem.h>
#include <OgreRenderSystemCapabilities.h>
#include <OgreResourceGroupManager.h>
#include <OgreRoot.h>
#include <OgreTechnique.h>

#include <stdexcept>

#include "nodes/surface_markers.h"
#include "rviz_plugins/splat_shaders.h"

namespace tactile_clay::rviz_plugins {
namespace {

// q of the ellipsoids that are drawn. In a shaken lattice these are 0.04 spacings from the surface (median),
// 0.1 at p95, after the Newton step. With 0.33 the distances are twice as large, and there are holes where
// the surface is seen at a flat angle.
constexpr float front_bound = 0.25f;
constexpr float level = 0.5f;         // level of the field at the surface
constexpr float longest_step = 0.6f;  // spacings; the longest step from an ellipsoid to the surface

const Ogre::String& group() {
  return Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME;
}

Ogre::MaterialPtr material(const std::string& name) {
  return Ogre::MaterialManager::getSingleton().create(name, group());
}

/// A texture that a program reads pixel by pixel.
void addTexture(Ogre::Pass& pass, const char* name) {
  Ogre::TextureUnitState* unit = pass.createTextureUnitState();
  unit->setTextureFiltering(Ogre::TFO_NONE);
  unit->setTextureAddressingMode(Ogre::TextureUnitState::TAM_CLAMP);
  pass.getFragmentProgramParameters()->setNamedConstant(name,
                                                        static_cast<int>(pass.getNumTextureUnitStates()) - 1);
}

Ogre::Vector3 vector(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

const char *SplatMaterials::front_scheme = "tactile_clay front",
           *SplatMaterials::field_scheme = "tactile_clay field";

std::string SplatMaterials::lacking() {
  const Ogre::RenderSystemCapabilities* card =
      Ogre::Root::getSingleton().getRenderSystem()->getCapabilities();
  if (!Ogre::GpuProgramManager::getSingleton().isSyntaxSupported("glsl")) return "shaders (GLSL)";
  if (!card->hasCapability(Ogre::RSC_HWRENDER_TO_TEXTURE)) return "rendering to textures";
  if (!card->hasCapability(Ogre::RSC_TEXTURE_FLOAT)) return "floating-point textures";
  if (card->getNumMultiRenderTargets() < 2) return "rendering to two textures at once";
  return "";
}

SplatMaterials::SplatMaterials(const std::string& name) : name_(name) {
  const std::string corner = program("corner", Ogre::GPT_VERTEX_PROGRAM, SplatShaders::corner);
  const std::string front = program("front", Ogre::GPT_FRAGMENT_PROGRAM, SplatShaders::front);
  const std::string field = program("field", Ogre::GPT_FRAGMENT_PROGRAM, SplatShaders::field);
  const std::string window = program("window", Ogre::GPT_VERTEX_PROGRAM, SplatShaders::window);
  const std::string surface = program("surface", Ogre::GPT_FRAGMENT_PROGRAM, SplatShaders::surface);

  splats_ = material(name + " splats");
  splats_->getTechnique(0)->setSchemeName(front_scheme);
  front_pass_ = splats_->getTechnique(0)->getPass(0);
  addSplatPass(*front_pass_, corner, front, front_bound);
  front_pass_->getFragmentProgramParameters()->setNamedConstant("bound", front_bound);

  Ogre::Technique* second = splats_->createTechnique();
  second->setSchemeName(field_scheme);
  field_pass_ = second->createPass();
  addSplatPass(*field_pass_, corner, field, 1.0f);
  field_pass_->setDepthCheckEnabled(false);
  field_pass_->setDepthWriteEnabled(false);
  field_pass_->setSceneBlending(Ogre::SBF_ONE, Ogre::SBF_ONE);
  addTexture(*field_pass_, "front");

  surface_ = material(name + " surface");
  surface_pass_ = surface_->getTechnique(0)->getPass(0);
  surface_pass_->setLightingEnabled(false);
  surface_pass_->setCullingMode(Ogre::CULL_NONE);
  surface_pass_->setVertexProgram(window);
  surface_pass_->setFragmentProgram(surface);
  for (const char* read : {"front", "field", "colour"}) addTexture(*surface_pass_, read);
  const nodes::Daylight daylight;
  const Ogre::GpuProgramParametersSharedPtr constants = surface_pass_->getFragmentProgramParameters();
  constants->setNamedConstant("level", level);
  constants->setNamedConstant("sun", vector(daylight.sun));
  constants->setNamedConstant("fill", vector(daylight.fill));
  constants->setNamedConstant(
      "light", Ogre::Vector4(daylight.from_below, daylight.from_sky, daylight.from_sun, daylight.from_fill));
  for (const Ogre::MaterialPtr& made : {splats_, surface_}) {
    made->load();
    for (unsigned short k = 0; k < made->getNumTechniques(); ++k)
      if (!made->getTechnique(k)->isSupported())
        throw std::runtime_error("the graphics card or its driver refuses a material: " +
                                 made->getUnsupportedTechniquesExplanation());
  }
}

SplatMaterials::~SplatMaterials() {
  for (const Ogre::MaterialPtr& made : {splats_, surface_})
    if (made) Ogre::MaterialManager::getSingleton().remove(made->getHandle());
  for (const Ogre::HighLevelGpuProgramPtr& made : programs_)
    Ogre::HighLevelGpuProgramManager::getSingleton().remove(made->getHandle());
}

/// Makes a program of the graphics card.
/// @return its name
std::string SplatMaterials::program(const std::string& role, Ogre::GpuProgramType type, const char* source) {
  const Ogre::HighLevelGpuProgramPtr made = Ogre::HighLevelGpuProgramManager::getSingleton().createProgram(
      name_ + " " + role, group(), "glsl", type);
  programs_.push_back(made);
  made->setSource(source);
  made->load();
  if (made->hasCompileError() || !made->isSupported())
    throw std::runtime_error("the shader '" + role + "' is refused (rviz --ogre-log prints the reason)");
  return made->getName();
}

void SplatMaterials::addSplatPass(Ogre::Pass& pass, const std::string& corner, const std::string& fragments,
                                  float bound) {
  pass.setLightingEnabled(false);
  pass.setCullingMode(Ogre::CULL_NONE);
  pass.setVertexProgram(corner);
  pass.setFragmentProgram(fragments);
  using Auto = Ogre::GpuProgramParameters;
  pass.getVertexProgramParameters()->setNamedAutoConstant("view", Auto::ACT_WORLDVIEW_MATRIX);
  pass.getVertexProgramParameters()->setNamedAutoConstant("projection", Auto::ACT_PROJECTION_MATRIX);
  pass.getVertexProgramParameters()->setNamedConstant("bound", bound);
  pass.getFragmentProgramParameters()->setNamedAutoConstant("projection", Auto::ACT_PROJECTION_MATRIX);
}

void SplatMaterials::read(const Ogre::TexturePtr& front, const Ogre::TexturePtr& field,
                          const Ogre::TexturePtr& colour) {
  field_pass_->getTextureUnitState(0)->setTexture(front);
  surface_pass_->getTextureUnitState(0)->setTexture(front);
  surface_pass_->getTextureUnitState(1)->setTexture(field);
  surface_pass_->getTextureUnitState(2)->setTexture(colour);
  const Ogre::Vector2 pixel(1.0f / static_cast<float>(front->getWidth()),
                            1.0f / static_cast<float>(front->getHeight()));
  for (Ogre::Pass* pass : {field_pass_, surface_pass_})
    pass->getFragmentProgramParameters()->setNamedConstant("pixel", pixel.ptr(), 1, 2);
}

void SplatMaterials::setCamera(const Ogre::Matrix4& projection, const Ogre::Matrix4& to_world) {
  surface_pass_->getFragmentProgramParameters()->setNamedConstant("projection", projection);
  surface_pass_->getFragmentProgramParameters()->setNamedConstant("to_world", to_world);
}

void SplatMaterials::setSpacing(float spacing) {
  surface_pass_->getFragmentProgramParameters()->setNamedConstant("farthest", longest_step * spacing);
}

}  // namespace tactile_clay::rviz_plugins
