#include "surface/clay_splats.h"

namespace tactile_clay::surface {
namespace {

// A particle of the outermost layer lacks neighbours: the centre of its kernel is moved inwards, or the
// kernel is narrow somewhere (thin sheets and single particles). The field at the surface depends on two
// layers. The particles within reach of the outermost layer are three layers.
constexpr float moved_outside = 0.09f;  // spacings
constexpr float width_outside = 0.9f;   // of the radius of a full lattice

}  // namespace

ClaySplats::ClaySplats(double spacing) : spacing_(spacing), kernels_(spacing) {}

void ClaySplats::findOuter(const std::vector<EllipsoidKernel>& kernels) {
  const float moved = moved_outside * static_cast<float>(spacing_);
  outer_.resize(kernels.size());
  for (std::size_t i = 0; i < kernels.size(); ++i)
    outer_[i] = (kernels[i].centre - particles_.position.at(i)).squaredNorm() > moved * moved ||
                kernels[i].reach.minCoeff() < width_outside * kernels_.reach();
}

std::vector<Splat> ClaySplats::update(const clay::VectorField& position,
                                      const std::vector<Eigen::Vector3f>& color) {
  particles_.take(position, color);
  std::vector<Splat> splats;
  if (particles_.color.empty()) return splats;
  const std::vector<EllipsoidKernel> kernels = kernels_.update(particles_.position);
  findOuter(kernels);
  const clay::Neighbourhood& near = kernels_.neighbourhood();
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    bool kept = outer_[i];
    for (std::uint32_t pair = near.begin(i); !kept && pair < near.end(i); ++pair)
      kept = outer_[near.other(pair)];
    if (kept) splats.push_back({kernels[i], particles_.color[i]});
  }
  return splats;
}

}  // namespace tactile_clay::surface
