#include "surface/clay_splats.h"

namespace tactile_clay::surface {
namespace {

// A kernel whose centre is the particle's own place and which is as wide as one of a full lattice in every
// direction has no surface within its reach: thin sheets and single particles are narrow somewhere.
constexpr float moved_inside = 0.06f;  // spacings
constexpr float width_inside = 0.95f;  // of the radius of a full lattice

}  // namespace

ClaySplats::ClaySplats(double spacing) : spacing_(spacing), kernels_(spacing) {}

const std::vector<Splat>& ClaySplats::update(const clay::VectorField& position,
                                             const std::vector<Eigen::Vector3f>& color) {
  particles_.take(position, color);
  splats_.clear();
  if (particles_.color.empty()) return splats_;
  const std::vector<EllipsoidKernel>& kernels = kernels_.update(particles_.position);
  const float moved = moved_inside * static_cast<float>(spacing_);
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    const bool inside = (kernels[i].centre - particles_.position.at(i)).squaredNorm() < moved * moved &&
                        kernels[i].reach.minCoeff() > width_inside * kernels_.reach();
    if (!inside) splats_.push_back({kernels[i], particles_.color[i]});
  }
  return splats_;
}

}  // namespace tactile_clay::surface
