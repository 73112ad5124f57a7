#include "surface/mesh_export.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "support/error_of.h"
#include "surface/clay_surface.h"

namespace tactile_clay::surface::mesh_export_test {
namespace {

TriangleMesh someMesh() {
  clay::VectorField position;
  position.resize(27);
  for (int i = 0; i < 27; ++i)
    position.set(i, 0.005f * Eigen::Vector3f(static_cast<float>(i % 3), static_cast<float>(i / 3 % 3),
                                             static_cast<float>(i / 9)));
  return ClaySurface(0.005).update(position, std::vector<Eigen::Vector3f>(27, {1.0f, 0.5f, 0.0f}));
}

template <typename T>
T at(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST(MeshExport, PlyHoldsTheMesh) {
  const TriangleMesh mesh = someMesh();
  const std::string file = ply(mesh);
  const std::size_t body = file.find("end_header\n") + 11;
  EXPECT_EQ(file.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0u);
  EXPECT_NE(file.find("element vertex " + std::to_string(mesh.position.size()) + "\n"), std::string::npos);
  EXPECT_NE(file.find("element face " + std::to_string(mesh.triangles.size()) + "\n"), std::string::npos);
  constexpr std::size_t corner_bytes = 27, face_bytes = 13;
  const std::size_t faces = body + corner_bytes * mesh.position.size();
  ASSERT_EQ(file.size(), faces + face_bytes * mesh.triangles.size());
  EXPECT_EQ(at<float>(file, body), mesh.position[0].x());
  EXPECT_EQ(at<std::uint8_t>(file, body + 24), 255);
  EXPECT_EQ(at<std::uint8_t>(file, body + 25), 128);
  EXPECT_EQ(at<std::uint8_t>(file, faces), 3);
  EXPECT_EQ(at<std::uint32_t>(file, faces + 1), mesh.triangles[0][0]);
}

TEST(MeshExport, StlIsWatertightByItsPlaces) {
  const TriangleMesh mesh = someMesh();
  const std::string file = stl(mesh);
  ASSERT_EQ(file.size(), 84 + 50 * mesh.triangles.size());
  EXPECT_EQ(at<std::uint32_t>(file, 80), mesh.triangles.size());
  EXPECT_NE(file.rfind("solid", 0), 0u);  // readers would take it for text
  // Corners are identified by their bits only, as in programs that read such files.
  TriangleMesh read;
  std::map<std::array<float, 3>, std::uint32_t> known;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    auto& triangle = read.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const auto place = at<std::array<float, 3>>(file, 84 + 50 * t + 12 + 12 * k);
      const auto [found, is_new] = known.emplace(place, read.position.size());
      if (is_new) read.position.emplace_back(place[0], place[1], place[2]);
      triangle[k] = found->second;
    }
  }
  EXPECT_TRUE(isClosedManifold(read));
  EXPECT_EQ(read.position.size(), mesh.position.size());
  EXPECT_NEAR(volumeOf(read) / volumeOf(mesh), 1e9, 1e4);  // mm^3
}

TEST(MeshExport, TheNameTellsTheFormat) {
  const TriangleMesh mesh = someMesh();
  EXPECT_EQ(meshFile(mesh, "a/b.ply"), ply(mesh));
  EXPECT_EQ(meshFile(mesh, "b.stl"), stl(mesh));
  EXPECT_EQ(errorOf([&] { meshFile(mesh, "b.obj"); }),
            "mesh 'b.obj': expected a name that ends in .ply or .stl");
}

}  // namespace
}  // namespace tactile_clay::surface::mesh_export_test
