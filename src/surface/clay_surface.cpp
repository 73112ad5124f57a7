#include "surface/clay_surface.h"

#include <algorithm>
#include <cmath>

#include "surface/marching_cubes.h"

namespace tactile_clay::surface {
namespace {

constexpr double cell = 0.5;  // spacings
constexpr float lowest_level = 0.3f, highest_level = 0.8f;

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
    : spacing_(spacing), kernels_(spacing), grid_(static_cast<float>(cell * spacing)) {}

TriangleMesh ClaySurface::update(const clay::VectorField& position,
                                 const std::vector<Eigen::Vector3f>& color) {
  particles_.take(position, color);
  TriangleMesh mesh;
  block_of_.clear();
  if (particles_.color.empty()) return mesh;
  const std::vector<EllipsoidKernel> kernels = kernels_.update(particles_.position);
  boxes_.clear();
  for (const EllipsoidKernel& kernel : kernels)
    boxes_.push_back({kernel.centre - kernel.reach, kernel.centre + kernel.reach});
  grid_.update(boxes_,
               [&](std::uint32_t k, const FieldGrid::Window& window) { addKernel(kernels[k], window); });
  level_ = grid_.levelOf(static_cast<double>(kernels.size()) * std::pow(spacing_, 3.0), lowest_level,
                         highest_level);
  march(grid_, level_, mesh, block_of_);
  setNormals(mesh);
  paint(kernels, mesh);
  return mesh;
}

void ClaySurface::paint(const std::vector<EllipsoidKernel>& kernels, TriangleMesh& mesh) const {
  // Most blocks have clay of one colour.
  std::vector<char> mixed(grid_.blocks().size(), 0);
  std::vector<Eigen::Vector3f> first(mixed.size(), Eigen::Vector3f::Zero());
  for (std::size_t b = 0; b < mixed.size(); ++b) {
    bool found = false;
    grid_.forEachKernel(b, [&](std::uint32_t k) {
      if (!found) {
        first[b] = particles_.color[k];
        found = true;
      }
      mixed[b] |= particles_.color[k] != first[b];
    });
  }
  mesh.color.resize(mesh.position.size());
  for (std::size_t c = 0; c < mesh.position.size(); ++c) {
    const std::uint32_t b = block_of_[c];
    mesh.color[c] = first[b];
    if (!mixed[b]) continue;
    float weight = 0.0f;
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    grid_.forEachKernel(b, [&](std::uint32_t k) {
      const Eigen::Vector3f d = mesh.position[c] - kernels[k].centre;
      if ((d.cwiseAbs() - kernels[k].reach).maxCoeff() > 0.0f) return;
      const float a = std::max(0.0f, 1.0f - d.dot(kernels[k].shape * d));
      const float w = kernels[k].weight * a * a * a;
      weight += w;
      color += w * particles_.color[k];
    });
    if (weight > 0.0f) mesh.color[c] = color / weight;
  }
}

}  // namespace tactile_clay::surface
