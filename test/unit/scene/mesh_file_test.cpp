#include "scene/mesh_file.h"

#include <sys/stat.h>

#include <cstring>
#include <sstream>

#include "clay/solid.h"
#include "support/error_of.h"
#include "support/meshes.h"
#include "support/scratch_folder.h"

namespace tactile_clay::scene::mesh_file_test {
namespace {

using Eigen::Vector3d;

std::string stlText(const Triangles& mesh) {
  std::ostringstream out;
  out << "solid box\n";
  for (const Triangles::Triangle& t : mesh.triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) out << "vertex " << mesh.vertices[t[k]].transpose() << "\n";
    out << "endloop\nendfacet\n";
  }
  return out.str() + "endsolid box\n";
}

std::string stlBinary(const Triangles& mesh) {
  std::string out(80, ' ');
  const auto put = [&](const auto& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  put(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangles::Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) put(0.0f);
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) put(static_cast<float>(mesh.vertices[t[k]][axis]));
    put(std::uint16_t{0});
  }
  return out;
}

/// A box of four-cornered faces, in two groups.
std::string obj() {
  return "o box\nv -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\ng "
         "lower\n"
         "f 1 3 4 2\nf 1 2 6 5\nf 3 7 8 4\ng upper\nf 5 6 8 7\nf 1 5 7 3\nf 2 4 8 6\n";
}

/// The same box half as large, in cm, on a node that is turned by 90 degrees about z, moved by 1 cm and twice
/// as large.
/// @param library text before the scene
/// @param inner further text in the node
std::string dae(const Triangles& mesh, const std::string& library = "", const std::string& inner = "") {
  std::ostringstream out;
  out << "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\">"
         "<asset><unit name=\"centimeter\" "
         "meter=\"0.01\"/><up_axis>Y_UP</up_axis></asset><library_geometries>"
         "<geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" count=\""
      << 3 * mesh.vertices.size() << "\">";
  for (const Vector3d& v : mesh.vertices) out << 0.5 * v.transpose() << " ";
  out << "</float_array><technique_common><accessor source=\"#a\" count=\"" << mesh.vertices.size()
      << "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param "
         "name=\"Z\" "
         "type=\"float\"/></accessor></technique_common></source><vertices id=\"v\"><input "
         "semantic=\"POSITION\" "
         "source=\"#p\"/></vertices><triangles count=\""
      << mesh.triangles.size() << "\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>";
  for (const Triangles::Triangle& t : mesh.triangles) out << t.transpose() << " ";
  out << "</p></triangles></mesh></geometry></library_geometries>" << library
      << "<library_visual_scenes><visual_scene "
         "id=\"s\"><node id=\"n\">"
         "<matrix>0 -2 0 1  2 0 0 0  0 0 2 0  0 0 0 1</matrix><instance_geometry "
         "url=\"#g\"/>"
      << inner
      << "</node></visual_scene>"
         "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
  return out.str();
}

const Vector3d half(1.0, 1.0, 1.0);
const Triangles box = boxOfTriangles(-half, half);

class MeshFile : public ScratchFolder {
 protected:
  std::string complaint(const std::string& file, const Vector3d& scale = Vector3d::Ones()) const {
    return errorOf([&] { loadMesh(file, scale); });
  }
  void expectComplaint(const std::string& file, const std::string& words) const {
    const std::string said = complaint(file);
    EXPECT_NE(said.find(words), std::string::npos) << said;
    EXPECT_NE(said.find(file), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
};

/// Expects that a mesh is a box about a point.
void expectBox(const clay::Mesh& mesh, const Vector3d& centre, const Vector3d& half_extents) {
  clay::Solid solid;
  solid.size = half_extents;
  for (int k = 0; k < 125; ++k) {
    const Vector3d p = Vector3d(k % 5 - 2.1, k / 5 % 5 - 2.2, k / 25 - 2.3).cwiseProduct(0.6 * half_extents);
    EXPECT_NEAR(mesh.surface(centre + p).distance, clay::surface(solid, p).distance,
                1e-6 * half_extents.norm());
  }
}

TEST_F(MeshFile, TheThreeKindsGiveTheSameBox) {
  const Vector3d one = Vector3d::Ones(), zero = Vector3d::Zero();
  expectBox(*loadMesh(write("text.stl", stlText(box)), one), zero, half);
  expectBox(*loadMesh(write("binary.STL", stlBinary(box)), one), zero, half);
  expectBox(*loadMesh(write("box.obj", obj()), one), zero, half);
  expectBox(*loadMesh(write("box.dae", dae(box)), one), {0.01, 0.0, 0.0}, 0.01 * half);
}

TEST_F(MeshFile, ScaleStretchesAndMirrors) {
  Triangles aside = boxOfTriangles({1.0, 2.0, 3.0}, {2.0, 4.0, 6.0});
  const std::string file = write("aside.stl", stlText(aside));
  expectBox(*loadMesh(file, {0.1, 0.2, 0.3}), {0.15, 0.6, 1.35}, {0.05, 0.2, 0.45});
  expectBox(*loadMesh(file, {-0.1, 0.2, 0.3}), {-0.15, 0.6, 1.35}, {0.05, 0.2, 0.45});
  expectBox(*loadMesh(file, {-0.1, -0.2, -0.3}), {-0.15, -0.6, -1.35}, {0.05, 0.2, 0.45});
  EXPECT_NE(complaint(file, {1.0, 0.0, 1.0}).find("has a scale of zero"), std::string::npos);
}

TEST_F(MeshFile, WhatCannotBeUsedIsNamed) {
  Triangles open = box;
  open.triangles.pop_back();
  expectComplaint(write("open.stl", stlText(open)), "is not closed: 3 open edges");
  expectComplaint(write("box.ply", "ply\n"), "is of kind 'ply', expected stl, dae or obj");
  expectComplaint(write("noise.dae", "<COLLADA"), "cannot be read as dae");
  expectComplaint(write("empty.stl", ""), "is empty");
  expectComplaint(write("short.stl", stlBinary(box).substr(0, 200)), "short.stl");
  expectComplaint(write("empty.obj", "# nothing\n"), "empty.obj");
  expectComplaint((folder / "none.stl").string(), "cannot be opened");
  expectComplaint(write("gltf.stl", "glTF\x02\x01\x02\x03"), "cannot be read as stl");
}

TEST_F(MeshFile, LargeMeshesAreRefused) {
  const Triangles globe = globeOfTriangles(1.0, 460);
  ASSERT_GT(globe.triangles.size(), 200000u);
  expectComplaint(write("globe.stl", stlBinary(globe)), "has more than 200000 triangles");
  std::filesystem::resize_file(write("large.stl", ""), (std::size_t{64} << 20) + 1);
  expectComplaint((folder / "large.stl").string(), "expected at most 67108864");
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int k = 0; k < times; ++k) all += text;
  return all;
}

std::string instanceOf(const std::string& node) {
  return "<instance_node url=\"#" + node + "\"/>";
}

/// A library of nodes n0, n1, ..., each of which names the next one.
/// @param times how often each node names the next one
std::string chainOfNodes(int nodes, int times) {
  std::string library = "<library_nodes>";
  for (int k = 0; k < nodes; ++k) {
    const std::string next = k + 1 < nodes ? repeated(instanceOf("n" + std::to_string(k + 1)), times) : "";
    library += "<node id=\"n" + std::to_string(k) + "\">" + next + "</node>";
  }
  return library + "</library_nodes>";
}

TEST_F(MeshFile, NodesThatNameNodesAreFollowed) {
  const std::string file = dae(box, chainOfNodes(3, 2), instanceOf("n0"));
  expectBox(*loadMesh(write("box.dae", file), Vector3d::Ones()), {0.01, 0.0, 0.0}, 0.01 * half);
}

TEST_F(MeshFile, WhatEndsItsReaderIsRefused) {
  const std::string circle = "<library_nodes><node id=\"a\">" + instanceOf("b") + "</node><node id=\"b\">" +
                             instanceOf("a") + "</node></library_nodes>";
  expectComplaint(write("circle.dae", dae(box, circle, instanceOf("a"))), "reader");
#ifndef __SANITIZE_ADDRESS__  // under which memory has no limit
  expectComplaint(write("doubled.dae", dae(box, chainOfNodes(40, 2), instanceOf("n0"))), "reader");
#endif
  const std::string nested = repeated("<node>", 200000) + repeated("</node>", 200000);
  expectComplaint(write("nested.dae", dae(box, "", nested)), "reader");
  std::string wide = dae(box);
  wide.replace(wide.find("stride=\"3\""), 10, "stride=\"4000000000\"");
  expectComplaint(write("wide.dae", wide), "reader");
}

TEST_F(MeshFile, NoOtherFileIsOpened) {
  const std::string pipe = (folder / "pipe.mtl").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  expectBox(*loadMesh(write("box.obj", "mtllib pipe.mtl\n" + obj()), Vector3d::Ones()), Vector3d::Zero(),
            half);
}

}  // namespace
}  // namespace tactile_clay::scene::mesh_file_test
