#include "scene/robot_model.h"

#include <sys/stat.h>

#include <cstdlib>

#include "scene/solids.h"
#include "support/error_of.h"
#include "support/meshes.h"
#include "support/scratch_folder.h"

namespace tactile_clay::scene::robot_model_test {
namespace {

using Eigen::Vector3d;

std::string robot(const std::string& inside) {
  return "<?xml version=\"1.0\"?>\n<robot name=\"r\" xmlns:xacro=\"http://wiki.ros.org/xacro\">\n" + inside +
         "</robot>\n";
}
std::string link(const std::string& name, const std::string& geometry = "") {
  return "<link name=\"" + name + "\">" +
         (geometry.empty()
              ? ""
              : "<collision><origin xyz=\"0 0 0.1\"/><geometry>" + geometry + "</geometry></collision>") +
         "</link>\n";
}
std::string joint(const std::string& type, const std::string& parent, const std::string& child) {
  return "<joint name=\"" + parent + "_" + child + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/><origin xyz=\"0.01 0 0\"/></joint>\n";
}
const std::string box = "<box size=\"0.2 0.2 0.2\"/>";

class RobotModel : public ScratchFolder {
 protected:
  std::string load(const std::string& xml, const std::string& name = "desk.urdf") const {
    return loadRobotModel(write(name, xml));
  }
  std::string complaint(const std::string& xml, const std::string& name = "desk.urdf") const {
    return errorOf([&] { Solids(load(xml, name), {}); });
  }
  void expectComplaint(const std::string& xml, const std::string& words) const {
    const std::string said = complaint(xml);
    EXPECT_NE(said.find(words), std::string::npos) << said.substr(0, 300);
    EXPECT_NE(said.find((folder / "desk.urdf").string()), std::string::npos) << said.substr(0, 300);
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
};

TEST_F(RobotModel, WhatIsReadyIsLeftAsItIs) {
  const std::string xml =
      robot(link("world") + "<!-- a table -->" + link("table", box) + joint("fixed", "world", "table"));
  EXPECT_EQ(load(xml), xml);
  const std::string made = load(robot(link("base_link", box)));
  EXPECT_EQ(readyModel(made, "/elsewhere"), made);
}

TEST_F(RobotModel, AnotherRootHangsOnTheWorld) {
  const std::string made = load(robot(link("base_link", box)));
  EXPECT_NE(made.find("<joint name=\"world_to_base_link\" type=\"fixed\">"), std::string::npos) << made;
  EXPECT_NE(made.find("<link name=\"world\"/>"), std::string::npos) << made;
  const auto solids = Solids(made, {}).at(0.0);
  ASSERT_EQ(solids.size(), 1u);
  EXPECT_TRUE(solids[0].pose.translation().isApprox(Vector3d(0.0, 0.0, 0.1)));
}

TEST_F(RobotModel, TheJointOfTheWorldHasANameOfItsOwn) {
  const std::string xml = robot(link("a", box) + link("b") +
                                "<joint name=\"world_to_a\" type=\"fixed\"><parent link=\"a\"/><child "
                                "link=\"b\"/></joint>");
  EXPECT_NE(load(xml).find("\"world_to_a_\""), std::string::npos);
  EXPECT_EQ(complaint(xml), "");
}

TEST_F(RobotModel, FloatingAndPlanarJointsAreFixedAtTheirOrigins) {
  for (const std::string type : {"floating", "planar"}) {
    const std::string made = load(robot(link("world") + link("table", box) + joint(type, "world", "table")));
    EXPECT_EQ(made.find(type), std::string::npos) << made;
    const Solids solids(made, {});
    EXPECT_TRUE(solids.at(0.0)[0].pose.translation().isApprox(Vector3d(0.01, 0.0, 0.1)));
    EXPECT_TRUE(solids.joints(0.0).empty());
  }
}

TEST_F(RobotModel, LinksThatAreNoTreeAreNamed) {
  expectComplaint(robot(link("world") + link("a") + link("b") + joint("fixed", "world", "a")),
                  "links 'b' and 'world' are both roots");
  expectComplaint(
      robot(link("world") + link("a") + link("b") + joint("fixed", "a", "b") + joint("fixed", "b", "a")),
      "hangs on itself in a loop");
  expectComplaint(robot(link("a") + joint("fixed", "a", "a")), "hangs on itself in a loop");
  expectComplaint(robot(link("world") + joint("fixed", "world", "moon")),
                  "line 4: joint 'world_moon' has the child link 'moon'");
  expectComplaint(robot(link("world") + link("a") + joint("fixed", "moon", "a")),
                  "has the parent link 'moon'");
  expectComplaint(robot(link("world") + link("a") + link("b") + joint("fixed", "world", "a") +
                        joint("fixed", "world", "b") + joint("fixed", "a", "b")),
                  "link 'b' hangs on two joints");
  expectComplaint(robot(link("base") + link("world") + joint("fixed", "base", "world")),
                  "link 'world' hangs on another link");
  expectComplaint(robot(link("world") + link("tracker") + joint("fixed", "world", "tracker")),
                  "name of a frame of the rig");
  expectComplaint(robot(link("world") + link("world")), "stands there twice");
  expectComplaint(robot(""), "a robot without links");
  expectComplaint(robot("<link/>"), "a link without a name");
  expectComplaint("<sdf version='1.6'><model/></sdf>", "expected URDF XML with the element robot, not sdf");
  expectComplaint("<robot name='r'><link name='a'>", "expected URDF XML");
  expectComplaint("", "is empty");
  expectComplaint("<!-- nothing -->", "expected URDF XML");
}

TEST_F(RobotModel, DepthAndNumberOfLinksAreBounded) {
  std::string deep, chain = link("world"), before = "world";
  for (int k = 0; k < 100000; ++k) deep += "<a>";
  expectComplaint(robot(link("world") + deep), "deep in each other");
  for (int k = 0; k < 50000; ++k) {
    const std::string name = "l" + std::to_string(k);
    chain += link(name) + joint("fixed", before, name);
    before = name;
  }
  expectComplaint(robot(chain), "50001 links, expected at most 1000");
  std::string bomb =
      "<!DOCTYPE r [<!ENTITY a \"1\"><!ENTITY b \"&a;&a;\">]><robot name='&b;'>" + link("world") + "</robot>";
  EXPECT_LT(complaint(bomb).size(), 400u);
}

TEST_F(RobotModel, NumberOfSolidsIsBounded) {
  std::string many = "<link name=\"world\">";
  for (int k = 0; k < 1001; ++k) many += "<collision><geometry>" + box + "</geometry></collision>";
  const std::string said = complaint(robot(many + "</link>"));
  EXPECT_NE(said.find("more than 1000 collisions"), std::string::npos) << said;
}

TEST_F(RobotModel, EncodingsAreReadAsDeclared) {
  const std::string inside =
      "<!-- Tisch f\xfcr Gef\xe4\xdf"
      "e -->\n" +
      link("world");
  const std::string latin =
      load("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<robot name=\"r\">" + inside + "</robot>");
  EXPECT_NE(latin.find("f\xc3\xbcr Gef\xc3\xa4\xc3\x9f"
                       "e"),
            std::string::npos)
      << latin;
  EXPECT_NE(latin.find("encoding=\"UTF-8\""), std::string::npos) << latin;
  expectComplaint("<?xml version=\"1.0\"?>\n<robot name=\"r\">" + inside + "</robot>",
                  "desk.urdf:2: bytes that are no UTF-8");
  expectComplaint(
      "<?xml version=\"1.0\" encoding=\"klingon\"?>\n<robot name=\"r\">" + link("world") + "</robot>",
      "encoding 'klingon' is unknown");
  expectComplaint("<?xml version=\"1.0\" encoding=\"US-ASCII\"?>\n<robot name=\"r\">" + inside + "</robot>",
                  "desk.urdf:2: bytes that are no US-ASCII");
  std::string wide = "\xff\xfe";
  for (const char c : "<?xml version='1.0' encoding='UTF-16'?>" + robot(link("world")).substr(21))
    wide += {c, '\0'};
  EXPECT_EQ(complaint(wide), "");
}

TEST_F(RobotModel, CapsulesAreCylindersWithTwoSpheres) {
  const Solids solids(
      load(robot("<link name=\"world\"><collision><origin xyz=\"0 0 0.1\" rpy=\"0 1.5707963267948966 0\"/>"
                 "<geometry><capsule radius=\"0.02\" length=\"0.06\"/></geometry></collision></link>")),
      {});
  const auto parts = solids.at(0.0);
  ASSERT_EQ(parts.size(), 3u);
  for (int k = 0; k < 300; ++k) {
    const Vector3d p(0.02 * (k % 10 - 4.7), 0.01 * (k / 10 % 5 - 2.2), 0.1 + 0.01 * (k / 50 - 2.6));
    double distance = INFINITY;
    for (const clay::Solid& part : parts)
      distance = std::min(distance, clay::surface(part, part.pose.inverse() * p).distance);
    const Vector3d axis(std::clamp(p.x(), -0.03, 0.03), 0.0, 0.1);
    const double exact = (p - axis).norm() - 0.02;
    if (exact > 0.0) {
      EXPECT_NEAR(distance, exact, 1e-12) << p.transpose();
    }
    EXPECT_EQ(distance < 0.0, exact < 0.0) << p.transpose();
  }
  expectComplaint(robot(link("world", "<capsule radius=\"0\" length=\"0.1\"/>")), "a capsule without size");
  expectComplaint(robot(link("world", "<capsule radius=\"0.1\"/>")),
                  "'length' of capsule is '', expected 1 number");
}

TEST_F(RobotModel, MeshesAreFoundBesideIt) {
  std::filesystem::create_directory(folder / "my meshes");
  write("my meshes/cube.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
        "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
  const FindPackage lab = [&](const std::string& name) {
    return name == "lab" ? folder.string() : std::string();
  };
  for (const std::string& name :
       {std::string("my meshes/cube.obj"), std::string("package://lab/my meshes/cube.obj"),
        (folder / "my meshes/cube.obj").string(), "file://" + (folder / "my meshes/cube.obj").string()}) {
    const std::string made =
        load(robot(link("world", "<mesh filename=\"" + name + "\" scale=\"0.1 -0.2 0.1\"/>")));
    EXPECT_TRUE(made.find("filename=\"file:///") != std::string::npos ||
                made.find("package://") != std::string::npos)
        << made;
    const clay::Solid solid = Solids(made, {}, lab).at(0.0).at(0);
    ASSERT_EQ(solid.shape, clay::Solid::Shape::mesh);
    EXPECT_NEAR(clay::surface(solid, {0.05, -0.19, 0.05}).distance, -0.01, 1e-7);
    EXPECT_TRUE(clay::boundsOf(solid).isApprox(
        Eigen::AlignedBox3d(Vector3d(0, -0.2, 0), Vector3d(0.1, 0, 0.1)), 1e-6));
  }
  const std::string said = complaint(robot(link("table", "<mesh filename=\"none.stl\"/>")));
  EXPECT_NE(said.find("link 'table' has a mesh as collision: " + (folder / "none.stl").string()),
            std::string::npos)
      << said;
}

class Xacro : public RobotModel {
 protected:
  void SetUp() override {
    RobotModel::SetUp();
    const char* path = std::getenv("PATH");
    path_ = path == nullptr ? "" : path;
    std::filesystem::create_directory(folder / "bin");
  }
  void TearDown() override {
    setenv("PATH", path_.c_str(), 1);
    RobotModel::TearDown();
  }
  /// Puts a program xacro before all others.
  void install(const std::string& script) const {
    const std::string file = write("bin/xacro", "#!/bin/sh\n" + script);
    chmod(file.c_str(), 0700);
    setenv("PATH", ((folder / "bin").string() + ":" + path_).c_str(), 1);
  }
  const std::string macros_ = robot("<xacro:macro name=\"table\" params=\"x\">" + link("table", box) +
                                    "</xacro:macro>\n" + link("world") + "<xacro:table x=\"${1 + 1}\"/>\n");

 private:
  std::string path_;
};

TEST_F(Xacro, ExpandsMacros) {
  // Stands in for xacro: gives the file without the macro, and its name.
  install("grep -v xacro: \"$1\" | sed 's/<robot/<!-- of '\"$(basename \"$1\")\"' --><robot/'\n");
  const std::string inside = "<xacro:table/>\n" + link("world", "<mesh filename=\"a/b.stl\"/>");
  const std::string made = load("<robot name=\"r\">\n" + inside + "</robot>", "desk.urdf.xacro");
  EXPECT_NE(made.find("of desk.urdf.xacro"), std::string::npos) << made;
  EXPECT_NE(made.find("file://" + (folder / "a/b.stl").string()), std::string::npos) << made;
}

TEST_F(Xacro, IsAskedForByNameWhereItIsMissing) {
  setenv("PATH", (folder / "bin").c_str(), 1);
  expectComplaint(macros_, "the program xacro that expands them is not there");
  EXPECT_NE(complaint(robot(link("world")), "desk.urdf.xacro").find("xacro"), std::string::npos);
  EXPECT_EQ(complaint(robot(link("world"))), "");  // its namespace alone does not make it one
}

TEST_F(Xacro, IsNotAskedForWhatIsCommentedOut) {
  const std::string xml = robot("<!-- <xacro:include filename=\"${f}\"/> -->\n" + link("world", box)) +
                          "<!-- <xacro:table/> -->\n";
  EXPECT_EQ(load(xml), xml);
}

TEST_F(Xacro, SaysWhatXacroSays) {
  install("echo 'Traceback\n  at a line\nundefined macro: table' >&2; exit 2\n");
  expectComplaint(
      macros_,
      "xacro (at most 1024 MiB of memory) ends with code 2: Traceback at a line undefined macro: table");
  install("echo '<robot'\n");
  expectComplaint(macros_, "expected URDF XML");
}

TEST_F(Xacro, TakesNotAllMemory) {
  install("exec python3 -c \"'x' * 9000000000\"\n");
  expectComplaint(macros_, "xacro (at most 1024 MiB of memory) ends with code 1: Traceback");
}

TEST_F(Xacro, WritesNoFileWithoutEnd) {
  const std::string endless = "exec head -c 40000000 /dev/zero";
  install(endless + "\n");
  expectComplaint(macros_, "what xacro writes is too large, expected at most 16 MiB");
  install(endless + " >&2\n");
  expectComplaint(macros_, "what xacro writes is too large, expected at most 16 MiB");
}

}  // namespace
}  // namespace tactile_clay::scene::robot_model_test
