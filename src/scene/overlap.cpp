#include "scene/overlap.h"

#include <cstddef>

namespace tactile_clay::scene {

std::vector<std::string> startsInside(const Scene& scene, const std::vector<clay::Solid>& solids) {
  std::vector<std::string> lines;
  for (const clay::Solid& solid : solids) {
    const Eigen::Isometry3d to_solid = solid.pose.inverse();
    const Eigen::AlignedBox3d box = boundsOf(solid);
    std::vector<std::size_t> inside(scene.bodies.size()), all(scene.bodies.size());
    for (const clay::InitialParticle& particle : scene.particles) {
      const Eigen::Vector3d place = to_solid * particle.position.cast<double>();
      ++all[particle.body];
      if (box.contains(place) && surface(solid, place).distance < -scene.config.spacing)
        ++inside[particle.body];
    }
    for (std::size_t b = 0; b < inside.size(); ++b)
      if (inside[b] > 0)
        lines.push_back("body '" + scene.bodies[b].name + "': " + std::to_string(inside[b]) + " of " +
                        std::to_string(all[b]) + " particles start inside the solid of '" + solid.name +
                        "', expected none (a mesh in millimetres needs a scale of 0.001)");
  }
  return lines;
}

}  // namespace tactile_clay::scene
