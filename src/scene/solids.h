#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "clay/solid.h"
#include "scene/scene.h"
#include "scene/text_file.h"

namespace tactile_clay::scene {

/// The rigid world of a scene: the collision geometry of a URDF, moved by the scene's motions.
class Solids {
 public:
  /// @param urdf_xml text of the robot model; see readyModel for what is done with it
  /// @param find_package for meshes of other packages; without it there are none
  /// @throws std::runtime_error where the model cannot be read, a motion names no joint of it that can move,
  ///         or a collision shape is not known, has no size, or is a mesh that is not closed
  Solids(const std::string& urdf_xml, const std::vector<Motion>& motions,
         const FindPackage& find_package = {});
  ~Solids();

  /// All solids, with their poses at time 0.
  const std::vector<clay::Solid>& solids() const;
  /// Their poses, by time (s); good as long as this lives.
  clay::SolidMotion motion() const;
  /// Solids with their poses at time t (s).
  std::vector<clay::Solid> at(double t) const;

  /// Position of each joint that can move at time t (rad or m), by name.
  std::map<std::string, double> joints(double t) const;

  /// What the motions ask for and do not get, a line each.
  const std::vector<std::string>& remarks() const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

}  // namespace tactile_clay::scene
