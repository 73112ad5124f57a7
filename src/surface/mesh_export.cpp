#include "surface/mesh_export.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "files/ends_with.h"

namespace tactile_clay::surface {
namespace {

// Both formats are little-endian, like all computers that ROS 1 runs on.
template <typename T>
void put(std::string& out, const T& value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

void put(std::string& out, const Eigen::Vector3f& v) {
  for (int a = 0; a < 3; ++a) put(out, v[a]);
}

}  // namespace

std::string ply(const TriangleMesh& mesh) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\ncomment tactile_clay, corners in metres\n"
      "element vertex " +
      std::to_string(mesh.position.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face " +
      std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t i = 0; i < mesh.position.size(); ++i) {
    put(out, mesh.position[i]);
    put(out, mesh.normal[i]);
    for (int c = 0; c < 3; ++c)
      put(out,
          static_cast<std::uint8_t>(std::lround(255.0f * std::min(std::max(mesh.color[i][c], 0.0f), 1.0f))));
  }
  for (const auto& triangle : mesh.triangles) {
    put(out, std::uint8_t{3});
    for (const std::uint32_t corner : triangle) put(out, corner);
  }
  return out;
}

std::string stl(const TriangleMesh& mesh) {
  constexpr float millimetres = 1000.0f;
  std::string out = "tactile_clay, corners in millimetres";
  out.resize(80, ' ');
  put(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f &p = mesh.position[a], &q = mesh.position[b], &r = mesh.position[c];
    const Eigen::Vector3d normal = (q - p).cast<double>().cross((r - p).cast<double>());
    put(out, Eigen::Vector3f(normal.normalized().cast<float>()));
    for (const Eigen::Vector3f& corner : {p, q, r}) put(out, Eigen::Vector3f(millimetres * corner));
    put(out, std::uint16_t{0});
  }
  return out;
}

std::string meshFile(const TriangleMesh& mesh, const std::string& file) {
  if (files::endsWith(file, ".ply")) return ply(mesh);
  if (files::endsWith(file, ".stl")) return stl(mesh);
  throw std::runtime_error("mesh '" + file + "': expected a name that ends in .ply or .stl");
}

}  // namespace tactile_clay::surface
