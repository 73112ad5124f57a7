#pragma once

#include <string>
#include <vector>

#include "clay/solid.h"
#include "scene/scene.h"

namespace tactile_clay::scene {

/// Bodies that start inside a solid: one line for each body and solid, with the number of its particles that
/// are deeper than one spacing. The clay leaves the solid, slowly. The usual cause is a mesh in millimetres.
std::vector<std::string> startsInside(const Scene& scene, const std::vector<clay::Solid>& solids);

}  // namespace tactile_clay::scene
