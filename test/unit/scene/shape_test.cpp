#include "scene/shape.h"

#include "scene/scene.h"
#include "support/error_of.h"
#include "support/meshes.h"
#include "support/scratch_folder.h"

namespace tactile_clay::scene::shape_test {
namespace {

using Eigen::Vector3d;
const std::string share = TACTILE_CLAY_SHARE;

Shape sphere(double radius) {
  Shape shape;
  shape.kind = Shape::Kind::sphere;
  shape.size.x() = radius;
  return shape;
}

Shape meshShape(const Triangles& mesh) {
  Shape shape;
  shape.kind = Shape::Kind::mesh;
  shape.mesh = std::make_shared<const clay::Mesh>(mesh.vertices, mesh.triangles);
  return shape;
}

double relativeVolume(const std::vector<Vector3d>& points, double spacing, double volume) {
  return static_cast<double>(points.size()) * std::pow(spacing, 3.0) / volume;
}

TEST(Shape, ASphereHasItsVolumeAndStandsOnItsOrigin) {
  constexpr double spacing = 0.005;
  for (double radius = 3.0 * spacing; radius < 8.0 * spacing; radius += 0.37 * spacing) {
    const auto points = latticeIn(sphere(radius), spacing);
    EXPECT_NEAR(relativeVolume(points, spacing, 4.0 / 3.0 * M_PI * std::pow(radius, 3.0)), 1.0, 0.05)
        << radius;
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : points) {
      EXPECT_LT((p - Vector3d(0, 0, radius)).norm(), radius + 0.16 * spacing);
      mean += p / static_cast<double>(points.size());
    }
    EXPECT_LT((mean - Vector3d(0, 0, radius)).norm(), 1e-9) << "lopsided";
  }
}

TEST(Shape, AMeshHasItsVolumeWhereItLies) {
  constexpr double spacing = 0.005;
  Triangles globe = globeOfTriangles(1.0, 32);
  for (Vector3d& v : globe.vertices)
    v = Vector3d(0.1, 0.2, 0.3) + v.cwiseProduct(Vector3d(0.023, 0.031, 0.019));
  const Shape shape = meshShape(globe);
  const auto points = latticeIn(shape, spacing);
  EXPECT_NEAR(relativeVolume(points, spacing, shape.mesh->volume()), 1.0, 0.02);
  for (const Vector3d& p : points) EXPECT_LT(shape.mesh->surface(p).distance, 0.16 * spacing);
}

TEST(Shape, AMeshOfWholeLayersIsFilledAsABox) {
  constexpr double spacing = 0.005;
  const Shape mesh = meshShape(boxOfTriangles({-0.02, -0.015, 0.0}, {0.02, 0.015, 0.025}));
  Shape box;
  box.size = {0.04, 0.03, 0.025};
  auto of_mesh = latticeIn(mesh, spacing), of_box = latticeIn(box, spacing);
  ASSERT_EQ(of_mesh.size(), of_box.size());
  for (std::size_t k = 0; k < of_box.size(); ++k) EXPECT_LT((of_mesh[k] - of_box[k]).norm(), 1e-12);
}

TEST(Shape, AMeshThatIsNoWholeNumberOfLayersHasNearlyItsVolume) {
  constexpr double spacing = 0.005;
  for (const double edge : {0.031, 0.032, 0.0325, 0.033, 0.034}) {
    const Shape cube = meshShape(boxOfTriangles(Vector3d::Zero(), Vector3d::Constant(edge)));
    EXPECT_NEAR(relativeVolume(latticeIn(cube, spacing), spacing, cube.mesh->volume()), 1.0, 0.08) << edge;
  }
}

class Bodies : public ScratchFolder {
 protected:
  Scene load(const std::string& body) const {
    return loadScene(
        write("scene.yaml",
              "spacing: 0.005\nurdf: table.urdf\nbodies:\n  - {name: a, material: dough, " + body + "}\n"),
        share);
  }
  std::string complaint(const std::string& body) const {
    return errorOf([&] { load(body); });
  }
  void expectComplaint(const std::string& body, const std::string& words) const {
    EXPECT_NE(complaint(body).find("scene.yaml:4: " + words), std::string::npos) << complaint(body);
  }
};

TEST_F(Bodies, AreSpheresAndMeshesBesideTheScene) {
  write("cube.obj",
        "v 0 0 0\nv 30 0 0\nv 0 30 0\nv 30 30 0\nv 0 0 30\nv 30 0 30\nv 0 30 30\nv 30 30 30\n"
        "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
  EXPECT_EQ(load("shape: mesh, mesh: cube.obj, scale: 0.001").particles.size(), 216u);
  EXPECT_EQ(load("shape: mesh, mesh: cube.obj, scale: [0.001, -0.001, 0.002]").particles.size(), 432u);
  const std::size_t ball = load("shape: sphere, size: [0.02]").particles.size();
  EXPECT_NEAR(static_cast<double>(ball), 268.0, 0.05 * 268.0);
  EXPECT_EQ(load("shape: sphere, size: 0.02").particles.size(), ball);
}

TEST_F(Bodies, SizeHasOneMeaningForEachShape) {
  write("line.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expectComplaint("shape: sphere, size: [0.02, 0.02, 0.02]",
                  "'size' has 3 numbers, expected one radius in m");
  expectComplaint("shape: cylinder, size: [0.02, 0.02]", "'size' has 2 numbers, expected radius below");
  expectComplaint("shape: box, size: 0.02", "'size' cannot be read, expected three edges in m");
  expectComplaint("shape: sphere, size: -1", "'size' expected numbers above zero");
  expectComplaint("shape: sphere", "key 'size' is missing, expected one radius in m");
  expectComplaint("shape: mesh, size: [1, 1, 1], mesh: line.obj", "'size' of a mesh, expected 'scale'");
  expectComplaint("shape: mesh", "key 'mesh' is missing, expected an STL, DAE or OBJ file");
  expectComplaint("shape: mesh, mesh: line.obj",
                  "mesh " + (folder / "line.obj").string() + " is not closed: 3 open edges");
  expectComplaint("shape: mesh, mesh: none.stl", (folder / "none.stl").string() + ": cannot be opened");
}

}  // namespace
}  // namespace tactile_clay::scene::shape_test
