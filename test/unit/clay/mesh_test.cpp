#include "clay/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "clay/clay.h"
#include "clay/solid.h"
#include "support/meshes.h"
#include "support/setups.h"

namespace tactile_clay::clay::mesh_test {
namespace {

using Eigen::Vector3d;

Mesh meshOf(const Triangles& t) {
  return Mesh(t.vertices, t.triangles);
}

std::string complaint(const Triangles& t) {
  try {
    meshOf(t);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

Solid boxSolid(const Vector3d& half) {
  Solid solid;
  solid.size = half;
  return solid;
}

std::vector<Vector3d> randomPoints(int count, double within) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> along(-within, within);
  std::vector<Vector3d> points;
  for (int k = 0; k < count; ++k) points.emplace_back(along(random), along(random), along(random));
  return points;
}

/// Expects by distance and normal that a mesh is the box of these half extents.
void expectBox(const Mesh& mesh, const Vector3d& half) {
  const Solid box = boxSolid(half);
  for (const Vector3d& p : randomPoints(2000, 0.06)) {
    const SurfacePoint exact = surface(box, p), found = mesh.surface(p);
    ASSERT_NEAR(found.distance, exact.distance, 1e-12) << p.transpose();
    const Vector3d q = half - p.cwiseAbs();
    double minimum[3] = {q.x(), q.y(), q.z()};
    std::sort(minimum, minimum + 3);
    const bool at_medial = exact.distance < 0.0 && minimum[1] - minimum[0] < 1e-9;
    if (!at_medial) {
      ASSERT_NEAR((found.normal - exact.normal).norm(), 0.0, 1e-9) << p.transpose();
    }
  }
}

TEST(Mesh, ABoxOfTrianglesIsTheBox) {
  const Vector3d half(0.03, 0.02, 0.01);
  const Mesh mesh = meshOf(boxOfTriangles(-half, half));
  expectBox(mesh, half);
  EXPECT_NEAR(mesh.volume(), 8.0 * half.prod(), 1e-15);
  EXPECT_TRUE(mesh.bounds().isApprox(Eigen::AlignedBox3d(-half, half)));
}

TEST(Mesh, HowTrianglesAreTurnedDoesNotMatter) {
  const Vector3d half(0.03, 0.02, 0.01);
  Triangles inwards = boxOfTriangles(-half, half), mixed = inwards, mirrored = inwards;
  inwards.turnRound();
  expectBox(meshOf(inwards), half);
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3)
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  expectBox(meshOf(mixed), half);
  for (Vector3d& v : mirrored.vertices) v.x() = -v.x();
  expectBox(meshOf(mirrored), half);
}

TEST(Mesh, CornersAtTheSamePlaceAreOne) {
  const Vector3d half(0.03, 0.02, 0.01);
  const Triangles box = boxOfTriangles(-half, half);
  Triangles soup;  // as an STL has it, and with the noise of single precision
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-3e-9, 3e-9);
  for (const Triangles::Triangle& t : box.triangles) {
    for (int k = 0; k < 3; ++k)
      soup.vertices.push_back(box.vertices[t[k]] + Vector3d(noise(random), noise(random), noise(random)));
    const auto last = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.emplace_back(last - 3, last - 2, last - 1);
  }
  const Mesh mesh = meshOf(soup);
  for (const Vector3d& p : randomPoints(500, 0.06))
    EXPECT_NEAR(mesh.surface(p).distance, surface(boxSolid(half), p).distance, 1e-8);
}

TEST(Mesh, TrianglesThatAreALineAreTolerated) {
  const Vector3d half(0.03, 0.02, 0.01);
  Triangles box = boxOfTriangles(-half, half);
  // Edge 0-1 of the triangle below has a corner in its middle, but that of the triangle in front does not: a
  // line closes the gap.
  box.vertices.emplace_back(0.0, -half.y(), -half.z());
  box.triangles.erase(box.triangles.begin() + 1);  // 0, 3, 1
  box.triangles.emplace_back(0, 3, 8);
  box.triangles.emplace_back(8, 3, 1);
  box.triangles.emplace_back(0, 8, 1);
  box.triangles.emplace_back(5, 5, 7);  // and one that is a line by its corners
  const Mesh mesh = meshOf(box);
  EXPECT_EQ(mesh.triangles(), 13u);
  expectBox(mesh, half);
}

double distanceTo(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const double share = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (a + share * (b - a) - p).norm();
}

/// Distance to a triangle: to its plane if the point lies above it, otherwise to its sides.
double distanceTo(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p) {
  const double sides = std::min({distanceTo(a, b, p), distanceTo(b, c, p), distanceTo(c, a, p)});
  Eigen::Matrix<double, 3, 2> edges;
  edges << b - a, c - a;
  const Eigen::Vector2d uv = (edges.transpose() * edges).inverse() * edges.transpose() * (p - a);
  const bool above = uv.minCoeff() >= 0.0 && uv.sum() <= 1.0;
  return above ? std::min(sides, (a + edges * uv - p).norm()) : sides;
}

TEST(Mesh, DistancesAreThoseToTheNearestTriangleByBruteForce) {
  // A globe that is dented, so that it has edges and corners of all kinds.
  Triangles globe = globeOfTriangles(0.03, 24);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> dent(0.7, 1.0);
  for (Vector3d& v : globe.vertices) v *= dent(random);
  const Mesh mesh = meshOf(globe);
  for (const Vector3d& p : randomPoints(400, 0.05)) {
    double nearest = INFINITY, solid_angle = 0.0;
    for (const Triangles::Triangle& t : globe.triangles) {
      const Vector3d a = globe.vertices[t[0]], b = globe.vertices[t[1]], c = globe.vertices[t[2]];
      nearest = std::min(nearest, distanceTo(a, b, c, p));
      // Van Oosterom and Strackee 1983: 4 pi inside, 0 outside.
      const Vector3d u = a - p, v = b - p, w = c - p;
      const double un = u.norm(), vn = v.norm(), wn = w.norm();
      solid_angle +=
          2.0 * std::atan2(u.dot(v.cross(w)), un * vn * wn + u.dot(v) * wn + v.dot(w) * un + w.dot(u) * vn);
    }
    const SurfacePoint found = mesh.surface(p);
    EXPECT_NEAR(std::abs(found.distance), nearest, 1e-12) << p.transpose();
    EXPECT_EQ(found.distance<0.0, solid_angle> 2.0 * M_PI) << p.transpose();
    EXPECT_NEAR(found.normal.norm(), 1.0, 1e-9);
    EXPECT_NEAR(mesh.surface(p - found.distance * found.normal).distance, 0.0, 1e-9);
  }
}

TEST(Mesh, BodiesOfAMeshAreAUnion) {
  // A table top on a leg that reaches into it.
  Triangles table = boxOfTriangles({-0.03, -0.03, 0.0}, {0.03, 0.03, 0.01});
  table.add(boxOfTriangles({-0.01, -0.01, -0.03}, {0.01, 0.01, 0.005}));
  const Mesh mesh = meshOf(table);
  for (const Vector3d& p : randomPoints(1000, 0.05)) {
    const double top = surface(boxSolid({0.03, 0.03, 0.005}), p - Vector3d(0, 0, 0.005)).distance;
    const double leg = surface(boxSolid({0.01, 0.01, 0.0175}), p - Vector3d(0, 0, -0.0125)).distance;
    EXPECT_NEAR(mesh.surface(p).distance, std::min(top, leg), 1e-12) << p.transpose();
  }
}

TEST(Mesh, ASurfaceTurnedInwardsWithinAnotherIsAHole) {
  const Vector3d outer(0.04, 0.04, 0.04), inner(0.03, 0.02, 0.03);
  Triangles hole = boxOfTriangles(-inner, inner), shell = boxOfTriangles(-outer, outer);
  hole.turnRound();
  shell.add(hole);
  const Mesh mesh = meshOf(shell);
  EXPECT_NEAR(mesh.volume(), 8.0 * (outer.prod() - inner.prod()), 1e-15);
  for (const Vector3d& p : randomPoints(1000, 0.05)) {
    const double distance =
        std::max(surface(boxSolid(outer), p).distance, -surface(boxSolid(inner), p).distance);
    if (surface(boxSolid(inner), p).distance > 0.0 || surface(boxSolid(outer), p).distance < 0.0) {
      EXPECT_NEAR(mesh.surface(p).distance, distance, 1e-12) << p.transpose();
    }
  }
}

TEST(Mesh, ASurfaceTurnedInwardsBesideAnotherIsABodyToo) {
  Triangles both;  // a corner of a cube, and a small cube in the box around that corner, but not in it
  both.vertices = {{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.1, 0.0}, {0.0, 0.0, 0.1}};
  both.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const Vector3d middle(0.08, 0.08, 0.08), half(0.01, 0.01, 0.01);
  Triangles cube = boxOfTriangles(middle - half, middle + half);
  cube.turnRound();
  both.add(cube);
  const Mesh mesh = meshOf(both);
  EXPECT_NEAR(mesh.volume(), 1e-3 / 6.0 + 8.0 * half.prod(), 1e-12);
  EXPECT_NEAR(mesh.surface(middle).distance, -0.01, 1e-12);
  EXPECT_GT(mesh.surface({0.05, 0.05, 0.05}).distance, 0.0);
}

TEST(Mesh, WhatIsFarOffIsToldAtOnce) {
  // A bowl: a globe with a hole in it, in which clay lies far from its wall.
  Triangles bowl = globeOfTriangles(0.05, 24), hole = globeOfTriangles(0.045, 24);
  hole.turnRound();
  bowl.add(hole);
  const Mesh mesh = meshOf(bowl);
  int far = 0;
  for (const Vector3d& p : randomPoints(5000, 0.06)) {
    const double exact = mesh.surface(p).distance, minimum = mesh.atLeast(p);
    EXPECT_LE(minimum, exact + 1e-12) << p.transpose();
    if (p.norm() < 0.03) far += minimum > 0.005 ? 1 : -1;
  }
  EXPECT_GT(far, 100) << "points in the middle of the bowl are not told";
}

TEST(Mesh, WhatIsNotClosedIsRefused) {
  const Vector3d half(0.03, 0.02, 0.01);
  Triangles open = boxOfTriangles(-half, half), shared = open;
  open.triangles.pop_back();
  EXPECT_EQ(complaint(open), "is not closed: 3 open edges, expected none");
  shared.triangles.emplace_back(0, 3, 4);
  shared.triangles.emplace_back(0, 4, 3);
  EXPECT_NE(complaint(shared).find("edges of more than two triangles"), std::string::npos)
      << complaint(shared);
  Triangles flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(complaint(flat), "encloses no volume, expected a closed surface about some");
  EXPECT_NE(complaint({}).find("has no size"), std::string::npos);
  Triangles nan = boxOfTriangles(-half, half);
  nan.vertices[3].x() = NAN;
  EXPECT_NE(complaint(nan).find("not finite"), std::string::npos);
}

TEST(Mesh, ClayRestsOnAMeshWithItsWeight) {
  Material material;
  ClayConfig config;
  config.spacing = 0.005;
  config.budget.substeps = 4;
  config.budget.iterations = 8;
  config.sleeping = false;  // so that the table is asked in each step
  const std::vector<InitialParticle> particles = block(5, 5, 4, config.spacing);
  const auto settle = [&](const Solid& table) {
    Clay clay(config, {material}, particles);
    Vector3d force = Vector3d::Zero();
    for (int frame = 0; frame < 60; ++frame) {
      clay.advance({}, {table}, config.frame);
      if (frame >= 50) force += clay.solidForces()[0] / 10.0;
    }
    return std::make_pair(force, clay.particles().position.at(0));
  };
  Solid box = boxSolid({0.1, 0.1, 0.02}), mesh;
  box.pose.translation().z() = mesh.pose.translation().z() = -0.02;
  mesh.shape = Solid::Shape::mesh;
  // Two triangles a side and many: corners and edges beneath the clay change nothing.
  Triangles fine = boxOfTriangles({-0.1, -0.1, -0.02}, {0.1, 0.1, 0.02});
  mesh.mesh = std::make_shared<const Mesh>(fine.vertices, fine.triangles);
  const auto on_box = settle(box), on_mesh = settle(mesh);
  const double weight = 100.0 * material.density * std::pow(0.005, 3.0) * 9.81;
  EXPECT_NEAR(on_box.first.z(), -weight, 1e-3 * weight);
  EXPECT_NEAR(on_mesh.first.z(), -weight, 1e-3 * weight);
  EXPECT_LT(on_mesh.first.head<2>().norm(), 1e-3 * weight);
  EXPECT_LT((on_mesh.second - on_box.second).norm(), 1e-6f);
}

}  // namespace
}  // namespace tactile_clay::clay::mesh_test
