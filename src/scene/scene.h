#pragma once

#include <string>
#include <vector>

#include "clay/clay.h"
#include "scene/files.h"

namespace tactile_clay::scene {

/// A body of clay: a shape filled with particles on a lattice.
struct Body {
  std::string name;
  std::uint8_t material = 0;                                // of Scene::materials
  Eigen::Vector3f color = Eigen::Vector3f::Constant(0.6f);  // RGB, 0-1
};

/// A piece of the motion of a joint of the URDF. Those of one joint follow one another: none begins before
/// the one before it has ended.
struct Motion {
  std::string joint;
  double start = 0.0;     // s
  double velocity = 0.0;  // rad/s or m/s
  double duration = 0.0;  // s; infinite where not given
};

/// A scene file, read and checked.
struct Scene {
  std::string name;
  std::string urdf;  // path of the robot model whose collision geometry the clay meets
  clay::ClayConfig config;
  std::vector<clay::Material> materials;
  std::vector<Body> bodies;
  std::vector<clay::InitialParticle> particles;
  std::vector<Motion> motions;
};

/// Reads a scene.
/// @param name a file, or the name of one in `<share>/config/scenes`
/// @param share the package's share folder, which holds `config`
/// @param spacing between particles, m, instead of the scene's own; 0: the scene's
/// @param find_package for files of other packages; without it there are none
/// @param material of all bodies, instead of their own; empty: their own
/// @throws std::runtime_error with one line: what, where, what was expected
Scene loadScene(const std::string& name, const std::string& share, double spacing = 0.0,
                const FindPackage& find_package = {}, const std::string& material = "");

/// Reads a material.
/// @param name a file, or the name of one in `<share>/config/materials`
/// @throws std::runtime_error with one line: what, where, what was expected
clay::Material loadMaterial(const std::string& name, const std::string& share);

/// Budget of a quality preset, such as `balanced`, from `<share>/config/quality.yaml`: scene/quality.h.
/// @throws std::runtime_error naming the known presets
clay::Budget loadQuality(const std::string& name, const std::string& share);

}  // namespace tactile_clay::scene
