#include "surface/coloured_particles.h"

#include <stdexcept>
#include <string>

namespace tactile_clay::surface {
namespace {

constexpr float farthest = 1000.0f;  // m, from the origin

}  // namespace

void ColouredParticles::take(const clay::VectorField& from, const std::vector<Eigen::Vector3f>& colors) {
  if (colors.size() != from.size())
    throw std::invalid_argument(std::to_string(colors.size()) + " colours of " + std::to_string(from.size()) +
                                " particles: expected one each");
  position.resize(from.size());
  color.resize(colors.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!(from.at(i).cwiseAbs().maxCoeff() <= farthest)) continue;
    position.set(kept, from.at(i));
    color[kept++] = colors[i];
  }
  position.resize(kept);
  color.resize(kept);
}

}  // namespace tactile_clay::surface
