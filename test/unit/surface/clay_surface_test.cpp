// The surface of the clay: closed, with the clay's volume, flat on flat clay and sharp at edges.
#include "surface/clay_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

#include "support/error_of.h"

namespace tactile_clay::surface::clay_surface_test {
namespace {

using Eigen::Vector3f;

constexpr float spacing = 0.005f;  // m
const Vector3f red(0.9f, 0.1f, 0.1f), blue(0.1f, 0.1f, 0.9f);

/// Particles of a cubic lattice where `inside` says so; lattice points are at half spacings.
std::vector<Vector3f> filled(int half, const std::function<bool(const Vector3f&)>& inside) {
  std::vector<Vector3f> points;
  for (int x = -half; x < half; ++x)
    for (int y = -half; y < half; ++y)
      for (int z = -half; z < half; ++z) {
        const Vector3f p = spacing * (Vector3f(x, y, z).array() + 0.5f).matrix();
        if (inside(p)) points.push_back(p);
      }
  return points;
}

std::vector<Vector3f> box(int nx, int ny, int nz) {
  return filled(20, [=](const Vector3f& p) {
    return std::abs(p.x()) < 0.5f * nx * spacing && std::abs(p.y()) < 0.5f * ny * spacing &&
           std::abs(p.z()) < 0.5f * nz * spacing;
  });
}

clay::VectorField field(const std::vector<Vector3f>& points) {
  clay::VectorField positions;
  positions.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) positions.set(i, points[i]);
  return positions;
}

TriangleMesh meshOf(const std::vector<Vector3f>& points) {
  return ClaySurface(spacing).update(field(points), std::vector<Vector3f>(points.size(), red));
}

double volumeOfParticles(std::size_t n) {
  return static_cast<double>(n) * std::pow(static_cast<double>(spacing), 3.0);
}

std::vector<Vector3f> turned(std::vector<Vector3f> points, const Eigen::Matrix3f& turn,
                             const Vector3f& shift) {
  for (Vector3f& p : points) p = turn * p + shift;
  return points;
}

const Eigen::Matrix3f some_turn =
    Eigen::AngleAxisf(0.7f, Vector3f(1.0f, 2.0f, -0.5f).normalized()).toRotationMatrix();

TEST(ClaySurface, IsClosedAndManifoldForAnyParticles) {
  std::mt19937 random(3);
  for (int round = 0; round < 60; ++round) {
    // From dust of single particles to a heap of twice the density, with all sets of inside corners of a
    // cell.
    std::uniform_real_distribution<float> place(0.0f, spacing * (2.0f + 0.2f * static_cast<float>(round)));
    std::vector<Vector3f> points(300);
    for (Vector3f& p : points) p = {place(random), place(random), place(random)};
    const TriangleMesh mesh = meshOf(points);
    ASSERT_GT(mesh.triangles.size(), 20u);
    ASSERT_TRUE(isClosedManifold(mesh)) << "round " << round;
  }
}

TEST(ClaySurface, OpenOrTouchingMeshesAreTold) {
  TriangleMesh mesh = meshOf(box(4, 4, 4));
  ASSERT_TRUE(isClosedManifold(mesh));
  TriangleMesh open = mesh;
  open.triangles.pop_back();
  EXPECT_FALSE(isClosedManifold(open));
  TriangleMesh flipped = mesh;
  std::swap(flipped.triangles[7][0], flipped.triangles[7][1]);
  EXPECT_FALSE(isClosedManifold(flipped));
  // Two closed surfaces that share one corner.
  TriangleMesh touching = mesh;
  const auto n = static_cast<std::uint32_t>(mesh.position.size());
  touching.position.insert(touching.position.end(), mesh.position.begin(), mesh.position.end());
  for (auto t : mesh.triangles) {
    for (std::uint32_t& corner : t) corner = corner == 0 ? 0 : corner + n;
    touching.triangles.push_back(t);
  }
  EXPECT_FALSE(isClosedManifold(touching));
}

TEST(ClaySurface, EnclosesTheVolumeOfTheClay) {
  const auto ball = [](const Vector3f& p) { return p.norm() < 9.0f * spacing; };
  std::vector<Vector3f> noisy = box(12, 14, 10);
  std::mt19937 random(5);
  std::normal_distribution<float> jitter(0.0f, 0.1f * spacing);
  for (Vector3f& p : noisy) p += Vector3f(jitter(random), jitter(random), jitter(random));
  for (const auto& points :
       {box(8, 8, 8), box(20, 20, 20), turned(box(10, 7, 7), some_turn, {0.1f, -0.2f, 0.05f}),
        filled(12, ball), box(20, 20, 3), noisy}) {
    const TriangleMesh mesh = meshOf(points);
    EXPECT_NEAR(volumeOf(mesh) / volumeOfParticles(points.size()), 1.0, 0.02)
        << points.size() << " particles";
  }
}

TEST(ClaySurface, FlatBlockIsFlat) {
  constexpr int n = 16;
  constexpr float half = 0.5f * n * spacing;
  for (const auto& turn : {Eigen::Matrix3f::Identity().eval(), some_turn}) {
    for (const float shift : {0.0f, 0.0011f, 0.0017f}) {
      const Vector3f at(shift, -0.4f * shift, 0.7f * shift);
      const TriangleMesh mesh = meshOf(turned(box(n, n, n), turn, at));
      int looked_at = 0;
      for (const Vector3f& corner : mesh.position) {
        const Vector3f p = turn.transpose() * (corner - at);
        for (int axis = 0; axis < 3; ++axis) {
          const Vector3f beside(p[(axis + 1) % 3], p[(axis + 2) % 3], 0.0f);
          if (beside.cwiseAbs().maxCoeff() > half - 2.0f * spacing || std::abs(p[axis]) < 0.5f * half)
            continue;
          EXPECT_NEAR(std::abs(p[axis]), half, 0.15f * spacing);
          ++looked_at;
        }
      }
      EXPECT_GT(looked_at, 1000);
    }
  }
}

TEST(ClaySurface, MarkOfAFingerStaysSharp) {
  // A groove as wide as a fingertip, 4 spacings, and 2 deep, along y.
  constexpr float top = 5.0f * spacing, depth = 2.0f * spacing, half_width = 2.0f * spacing;
  const TriangleMesh mesh = meshOf(filled(12, [](const Vector3f& p) {
    return std::abs(p.z()) < top && !(std::abs(p.x()) < half_width && p.z() > top - depth);
  }));
  float deepest = top, narrow = 0.0f, wide = half_width;
  for (const Vector3f& p : mesh.position) {
    if (std::abs(p.y()) > 6.0f * spacing || p.z() < 0.0f || std::abs(p.x()) > 8.0f * spacing) continue;
    const float down = (top - p.z()) / depth;
    if (std::abs(p.x()) < spacing) deepest = std::min(deepest, p.z());
    // From a tenth to nine tenths of the way down.
    if (down < 0.1f) wide = std::max(wide, 0.0f);
    if (down > 0.1f && down < 0.9f) {
      narrow = std::max(narrow, std::abs(p.x()));
      wide = std::min(wide, std::abs(p.x()));
    }
  }
  EXPECT_NEAR((top - deepest) / depth, 1.0f, 0.1f);
  EXPECT_LT((narrow - wide) / spacing, 1.0f) << "spacings that the wall is wide";
}

TEST(ClaySurface, ColoursBlendWhereBodiesMerge) {
  const std::vector<Vector3f> points = box(16, 8, 8);
  std::vector<Vector3f> colors;
  for (const Vector3f& p : points) colors.push_back(p.x() < 0.0f ? red : blue);
  const TriangleMesh mesh = ClaySurface(spacing).update(field(points), colors);
  ASSERT_EQ(mesh.color.size(), mesh.position.size());
  int mixed = 0;
  for (std::size_t i = 0; i < mesh.color.size(); ++i) {
    const float x = mesh.position[i].x() / spacing,
                share = (mesh.color[i].z() - red.z()) / (blue.z() - red.z());
    EXPECT_NEAR((mesh.color[i] - (red + share * (blue - red))).norm(), 0.0f, 1e-5f) << "no third colour";
    if (std::abs(x) > 3.0f) {
      EXPECT_NEAR(share, x < 0.0f ? 0.0f : 1.0f, 1e-6f);
    } else if (std::abs(x) < 0.3f) {
      EXPECT_NEAR(share, 0.5f, 0.25f);
      ++mixed;
    }
  }
  EXPECT_GT(mixed, 20);
}

TEST(ClaySurface, NormalsPointOutwards) {
  const TriangleMesh mesh = meshOf(filled(12, [](const Vector3f& p) { return p.norm() < 9.0f * spacing; }));
  for (std::size_t i = 0; i < mesh.position.size(); ++i) {
    EXPECT_NEAR(mesh.normal[i].norm(), 1.0f, 1e-5f);
    EXPECT_GT(mesh.normal[i].dot(mesh.position[i].normalized()), 0.8f);
  }
}

TEST(ClaySurface, OneParticleIsABallAndCrumbsDoNotVanish) {
  const TriangleMesh mesh = meshOf({{0.0013f, 0.0002f, 0.0021f}});
  EXPECT_TRUE(isClosedManifold(mesh));
  EXPECT_NEAR(volumeOf(mesh) / volumeOfParticles(1), 1.0, 0.35);  // of a ball 2.5 cells wide
  // Beside a block, whose level they share.
  std::vector<Vector3f> points = box(10, 10, 10);
  points.emplace_back(0.1f, 0.0f, 0.0f);
  float farthest = 0.0f;
  for (const Vector3f& p : meshOf(points).position) farthest = std::max(farthest, p.x());
  EXPECT_GT(farthest, 0.1f);
}

TEST(ClaySurface, SameParticlesGiveTheSameBits) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> place(0.0f, 10.0f * spacing);
  std::vector<Vector3f> points(900), colors;
  for (Vector3f& p : points) p = {place(random), place(random), place(random)};
  for (std::size_t i = 0; i < points.size(); ++i) colors.push_back(i % 2 == 0 ? red : blue);
  ClaySurface used(spacing);
  used.update(field(box(14, 14, 14)), std::vector<Vector3f>(14 * 14 * 14, red));
  const TriangleMesh a = used.update(field(points), colors),
                     b = ClaySurface(spacing).update(field(points), colors);
  ASSERT_EQ(a.position.size(), b.position.size());
  EXPECT_EQ(a.triangles, b.triangles);
  for (const auto member : {&TriangleMesh::position, &TriangleMesh::normal, &TriangleMesh::color})
    EXPECT_EQ(std::memcmp((a.*member).data(), (b.*member).data(), sizeof(Vector3f) * a.position.size()), 0);
}

TEST(ClaySurface, ClayThatMovesByCellsKeepsItsMesh) {
  const std::vector<Vector3f> points = box(6, 6, 6);
  const TriangleMesh here = meshOf(points),
                     there = meshOf(turned(points, Eigen::Matrix3f::Identity(), {spacing, 0, 0}));
  ASSERT_EQ(here.position.size(), there.position.size());
  Vector3f low = Vector3f::Constant(1.0f), moved = low;
  for (std::size_t i = 0; i < here.position.size(); ++i) {
    low = low.cwiseMin(here.position[i]);
    moved = moved.cwiseMin(there.position[i]);
  }
  EXPECT_NEAR((moved - low - Vector3f(spacing, 0, 0)).norm(), 0.0f, 1e-6f);
}

TEST(ClaySurface, WhatIsNoPlaceIsLeftOut) {
  std::vector<Vector3f> points = box(6, 6, 6);
  const TriangleMesh mesh = meshOf(points);
  points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f);
  points.emplace_back(0.0f, std::numeric_limits<float>::infinity(), 0.0f);
  points.emplace_back(0.0f, 0.0f, -3e30f);
  EXPECT_EQ(meshOf(points).triangles, mesh.triangles);
  EXPECT_TRUE(meshOf({}).triangles.empty());
  points.emplace_back(900.0f, -900.0f, 900.0f);  // far, but a place
  EXPECT_GT(meshOf(points).triangles.size(), mesh.triangles.size());
}

TEST(ClaySurface, BadInputIsToldInOneLine) {
  EXPECT_THROW(ClaySurface(0.1), std::invalid_argument);
  EXPECT_THROW(ClaySurface(spacing).update(field({{0, 0, 0}}), {}), std::invalid_argument);
  std::vector<Vector3f> dust;
  for (int i = 0; i < 40'000; ++i)
    dust.emplace_back(0.1f * (i % 40), 0.1f * (i / 40 % 40), 0.1f * (i / 1600));
  EXPECT_NE(errorOf([&] { meshOf(dust); }).find("expected clay that is less spread"), std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::surface::clay_surface_test
