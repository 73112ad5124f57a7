// The kernels that a picture of the clay needs: their sum at the surface is that of all kernels.
#include "surface/clay_splats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "surface/clay_surface.h"

namespace tactile_clay::surface::clay_splats_test {
namespace {

using Eigen::Vector3f;

constexpr float spacing = 0.005f;       // m
constexpr float sum_tolerance = 0.03f;  // of a field that is 1 inside of the clay

/// A cuboid of a lattice whose points are moved by up to `shake` spacings.
clay::VectorField block(int nx, int ny, int nz, float shake) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> moved(-shake, shake);
  clay::VectorField points;
  points.resize(static_cast<std::size_t>(nx * ny * nz));
  for (int k = 0; k < nx * ny * nz; ++k) {
    const Vector3f at(static_cast<float>(k % nx), static_cast<float>(k / nx % ny),
                      static_cast<float>(k / nx / ny));
    points.set(static_cast<std::size_t>(k),
               spacing * (at + Vector3f(moved(random), moved(random), moved(random))));
  }
  return points;
}

template <class Each, class KernelOf>
float fieldAt(const Vector3f& x, const Each& each, KernelOf kernelOf) {
  float sum = 0.0f;
  for (const auto& one : each) {
    const EllipsoidKernel& kernel = kernelOf(one);
    const Vector3f d = x - kernel.centre;
    sum += kernel.weight * std::pow(std::max(0.0f, 1.0f - d.dot(kernel.shape * d)), 3.0f);
  }
  return sum;
}

TEST(ClaySplats, SumAtTheSurfaceIsThatOfAllKernels) {
  const clay::VectorField points = block(14, 14, 14, 0.15f);
  const std::vector<Vector3f> colors(points.size(), Vector3f::Ones());
  ClaySplats chosen(spacing);
  const auto splats = chosen.update(points, colors);
  EXPECT_LT(splats.size(), points.size() * 9 / 10);
  Kernels all(spacing);
  const auto kernels = all.update(points);
  ClaySurface surface(spacing);
  const TriangleMesh mesh = surface.update(points, colors);
  for (std::size_t c = 0; c < mesh.position.size(); c += 17) {
    const Vector3f& at = mesh.position[c];
    const float sum = fieldAt(
        at, kernels, [](const EllipsoidKernel& k) -> const auto& { return k; });
    EXPECT_NEAR(fieldAt(
                    at, splats, [](const Splat& s) -> const auto& { return s.kernel; }),
                sum, sum_tolerance);
  }
}

TEST(ClaySplats, SheetsAndSingleParticlesAreKept) {
  for (const auto& points : {block(1, 1, 1, 0.0f), block(9, 9, 1, 0.0f), block(9, 9, 2, 0.1f)})
    EXPECT_EQ(
        ClaySplats(spacing).update(points, std::vector<Vector3f>(points.size(), Vector3f::Zero())).size(),
        points.size());
}

TEST(ClaySplats, EachHasTheColourOfItsParticle) {
  clay::VectorField points = block(3, 1, 1, 0.0f);
  points.set(1, Vector3f(NAN, 0.0f, 0.0f));
  ClaySplats chosen(spacing);
  const auto splats = chosen.update(points, {Vector3f::UnitX(), Vector3f::UnitY(), Vector3f::UnitZ()});
  ASSERT_EQ(splats.size(), 2u);
  EXPECT_EQ(chosen.particles(), 2u);
  EXPECT_EQ(splats[0].color, Vector3f::UnitX());
  EXPECT_EQ(splats[1].color, Vector3f::UnitZ());
  EXPECT_THROW(chosen.update(points, {}), std::invalid_argument);
  EXPECT_THROW(ClaySplats(0.03), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::surface::clay_splats_test
