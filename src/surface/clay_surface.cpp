#include "surface/clay_surface.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "surface/marching_cubes.h"

namespace tactile_clay::surface {
namespace {

constexpr double cell = 0.5;         // spacings
constexpr float farthest = 1000.0f;  // m, from the origin
constexpr float lowest_level = 0.3f, highest_level = 0.8f;
double checked(double spacing) {
  if (!(spacing >= 0.001 && spacing <= 0.02))
    throw std::invalid_argument("spacing " + std::to_string(spacing) + " m: expected 0.001 to 0.02");
  return spacing;
}

TACTILE_CLAY_MULTIVERSION
void addKernel(const EllipsoidKernel& kernel, const FieldGrid::Window& window) {
  const Eigen::Matrix3f& s = kernel.shape;
  const Lane dx = window.x() - kernel.centre.x();
  const Lane xx = s(0, 0) * dx;
  window.forEachRow([&](float y, float z, Lane& sums) {
    const float dy = y - kernel.centre.y(), dz = z - kernel.centre.z();
    const float linear = 2.0f * (s(0, 1) * dy + s(0, 2) * dz);
    const float rest = dy * (s(1, 1) * dy + 2.0f * s(1, 2) * dz) + s(2, 2) * dz * dz;
    const Lane a = positive(1.0f - (dx * (xx + linear) + rest));
    sums += kernel.weight * a * a * a;
  });
}

}  // namespace

ClaySurface::ClaySurface(double spacing)
    : spacing_(checked(spacing)), kernels_(spacing), grid_(static_cast<float>(cell * spacing)) {}

const TriangleMesh& ClaySurface::update(const clay::VectorField& position,
                                        const std::vector<Eigen::Vector3f>& color) {
  if (color.size() != position.size())
    throw std::invalid_argument(std::to_string(color.size()) + " colours of " +
                                std::to_string(position.size()) + " particles: expected one each");
  position_.resize(position.size());
  color_.resize(color.size());
  std::size_t finite = 0;
  for (std::size_t i = 0; i < position.size(); ++i) {
    if (!(position.at(i).cwiseAbs().maxCoeff() <= farthest)) continue;
    position_.set(finite, position.at(i));
    color_[finite++] = color[i];
  }
  position_.resize(finite);
  color_.resize(finite);

  mesh_.position.clear(), mesh_.normal.clear(), mesh_.color.clear(), mesh_.triangles.clear();
  block_of_.clear();
  if (finite == 0) return mesh_;
  const std::vector<EllipsoidKernel>& kernels = kernels_.update(position_);
  boxes_.clear();
  for (const EllipsoidKernel& kernel : kernels)
    boxes_.push_back({kernel.centre - kernel.reach, kernel.centre + kernel.reach});
  grid_.update(boxes_,
               [&](std::uint32_t k, const FieldGrid::Window& window) { addKernel(kernels[k], window); });
  level_ = grid_.levelOf(static_cast<double>(finite) * std::pow(spacing_, 3.0), lowest_level, highest_level);
  march(grid_, level_, mesh_, block_of_);
  setNormals(mesh_);
  paint(kernels);
  return mesh_;
}

void ClaySurface::paint(const std::vector<EllipsoidKernel>& kernels) {
  // Most blocks have clay of one colour.
  std::vector<char> mixed(grid_.blocks().size(), 0);
  std::vector<Eigen::Vector3f> first(mixed.size(), Eigen::Vector3f::Zero());
  for (std::size_t b = 0; b < mixed.size(); ++b) {
    bool found = false;
    grid_.forEachKernel(b, [&](std::uint32_t k) {
      if (!found) first[b] = color_[k], found = true;
      mixed[b] |= color_[k] != first[b];
    });
  }
  mesh_.color.resize(mesh_.position.size());
  for (std::size_t c = 0; c < mesh_.position.size(); ++c) {
    const std::uint32_t b = block_of_[c];
    mesh_.color[c] = first[b];
    if (!mixed[b]) continue;
    float weight = 0.0f;
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    grid_.forEachKernel(b, [&](std::uint32_t k) {
      const Eigen::Vector3f d = mesh_.position[c] - kernels[k].centre;
      if ((d.cwiseAbs() - kernels[k].reach).maxCoeff() > 0.0f) return;
      const float a = std::max(0.0f, 1.0f - d.dot(kernels[k].shape * d));
      const float w = kernels[k].weight * a * a * a;
      weight += w, color += w * color_[k];
    });
    if (weight > 0.0f) mesh_.color[c] = color / weight;
  }
}

}  // namespace tactile_clay::surface
