#pragma once

#include <string>
#include <vector>

#include "clay/clay.h"
#include "scene/files.h"

namespace tactile_clay::scene {

/// A body of clay: a shape filled with particles on a lattice.
struct Body {
  std::string name;
  std::uint8_t material = 0;                                // index into Scene::materials
  Eigen::Vector3f color = Eigen::Vector3f::Constant(0.6f);  // RGB, 0-1
};

/// rad/s or m/s: some half a radian, or half a metre, in a step of the clay. A faster turn would look slower.
inline constexpr double max_joint_speed = 100.0;

/// A piece of the motion of a joint of the URDF. The pieces of one joint follow one another without overlap.
struct Motion {
  std::string joint;
  double start = 0.0;     // s
  double velocity = 0.0;  // rad/s or m/s, at most max_joint_speed
  double duration = 0.0;  // s; infinite if not given
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
/// @param share the package's share folder, which contains `config`
/// @param spacing between particles, m, instead of the scene's own; 0: the scene's
/// @param find_package finds other packages; without it their files are not found
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
