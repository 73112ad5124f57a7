#include "scene/scene.h"
#include "scene/overlap.h"
#include "scene/robot_model.h"
#include "scene/solids.h"
#include "support/error_of.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace tactile_clay::scene::scene_test {
namespace {

const std::string share = TACTILE_CLAY_SHARE;

/// The error of loading a scene file with this text; empty if there is none.
std::string complaint(const std::string& text) {
  const std::string file = (std::filesystem::temp_directory_path() / "tactile_clay_scene_test.yaml").string();
  std::ofstream(file) << text;
  return errorOf([&] { loadScene(file, share); });
}

const std::string good =
    "urdf: table.urdf\n"
    "bodies:\n"
    "  - {name: a, material: dough, shape: box, size: [0.02, 0.02, 0.02]}\n";

TEST(Scene, EveryShippedSceneLoads) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(share + "/config/scenes")) {
    const Scene scene = loadScene(entry.path().stem().string(), share);
    EXPECT_FALSE(scene.particles.empty()) << entry.path();
    EXPECT_NO_THROW(clay::Clay(scene.config, scene.materials, scene.particles)) << entry.path();
    const Solids solids(loadRobotModel(scene.urdf), scene.motions);
    EXPECT_TRUE(startsInside(scene, solids.solids()).empty()) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 7);
}

TEST(Scene, ABodyThatStartsInsideASolidIsTold) {
  const Scene scene = loadScene("kindergarten", share);
  clay::Solid huge;  // as a mesh in millimetres
  huge.name = "table";
  huge.size = {200.0, 200.0, 100.0};
  const std::vector<std::string> lines = startsInside(scene, {huge});
  ASSERT_EQ(lines.size(), scene.bodies.size());
  EXPECT_EQ(lines[0].find("body 'red': 512 of 512 particles start inside the solid of 'table'"), 0U)
      << lines[0];
}

TEST(Scene, OneMaterialMayStandForThatOfAllBodies) {
  const Scene scene = loadScene("kindergarten", share, 0.0, {}, "putty");
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].name, "putty");
  EXPECT_EQ(scene.materials[0].density, loadMaterial("putty", share).density);
  for (const Body& body : scene.bodies) EXPECT_EQ(body.material, 0);
  EXPECT_NE(errorOf([] {
              loadScene("kindergarten", share, 0.0, {}, "granite");
            }).find("material 'granite' not found"),
            std::string::npos);
}

TEST(Material, EveryShippedOneLoads) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(share + "/config/materials")) {
    EXPECT_NO_THROW(loadMaterial(entry.path().stem().string(), share)) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 16);
}

/// Young's modulus of clays, 3 x stiffness, is 100 to 2000 times their yield stress; they do not spring back
/// from compression.
TEST(Material, ClaysWithSourcesAreStiffForTheirYieldStress) {
  for (const char* name :
       {"plasticine_20c", "plasticine_35c", "potters_clay_firm", "potters_clay_soft", "clay_paste"}) {
    const clay::Material m = loadMaterial(name, share);
    const double ratio = 3.0 / (2.0 * m.yield_strain);
    EXPECT_GE(ratio, 100.0) << name;
    EXPECT_LE(ratio, 2000.0) << name;
    EXPECT_GE(m.bulk_modulus, 10.0 * m.stiffness) << name;
  }
}

TEST(Material, KeysOfTimeAreReadAndChecked) {
  const std::string file =
      (std::filesystem::temp_directory_path() / "tactile_clay_material_test.yaml").string();
  const auto load = [&](const std::string& text) {
    std::ofstream(file) << text;
    return loadMaterial(file, share);
  };
  const clay::Material m = load("relaxation_time: 2\nflow_index: 0.5\n");
  EXPECT_EQ(m.relaxation_time, 2.0);
  EXPECT_EQ(m.flow_index, 0.5);
  EXPECT_EQ(load("relaxation_time: .inf\n").relaxation_time, std::numeric_limits<double>::infinity());
  EXPECT_NE(errorOf([&] { load("relaxation_time: 0\n"); }).find("expected >= 0.01 s"), std::string::npos);
  EXPECT_NE(errorOf([&] { load("flow_index: 1.5\n"); }).find("expected > 0, at most 1"), std::string::npos);
  EXPECT_NE(errorOf([&] { load("flow_index: 0\n"); }).find("expected > 0, at most 1"), std::string::npos);
}

TEST(Scene, ThePapersScenesHaveThePapersParticles) {
  EXPECT_EQ(loadScene("kindergarten", share).particles.size(), 2114u);
  EXPECT_EQ(loadScene("potters_wheel", share).particles.size(), 4169u);
}

TEST(Scene, SpacingIsTheOneNumberToChangeForAnotherResolution) {
  const Scene coarse = loadScene("kindergarten", share), fine = loadScene("kindergarten", share, 0.0025);
  EXPECT_DOUBLE_EQ(fine.config.spacing, 0.0025);
  EXPECT_EQ(fine.particles.size(), 8 * coarse.particles.size());
}

TEST(Scene, BodiesStartFlatOnTheTable) {
  for (const clay::InitialParticle& p : loadScene("kindergarten", share).particles) {
    EXPECT_GE(p.position.z(), 0.0024999f);
  }
}

TEST(Scene, SaysWhatIsKnownWhenASceneIsNot) {
  try {
    loadScene("volcano", share);
    FAIL() << "an unknown scene was loaded";
  } catch (const std::runtime_error& e) {
    const std::string what = e.what();
    EXPECT_NE(what.find("'volcano'"), std::string::npos) << what;
    EXPECT_NE(what.find("kindergarten"), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  }
}

TEST(Scene, ComplaintsNameFileLineAndExpectation) {
  EXPECT_EQ(complaint(good), "");
  EXPECT_NE(complaint(good + "colour: red\n").find(".yaml:4: unknown key 'colour'"), std::string::npos);
  EXPECT_NE(complaint("urdf: table.urdf\nbodies: 3\n").find(":2: 'bodies' expected a list"),
            std::string::npos);
  EXPECT_NE(complaint("urdf: table.urdf\n").find("no clay"), std::string::npos);
  EXPECT_NE(complaint("urdf: [\n").find("not YAML"), std::string::npos);
  EXPECT_NE(complaint("urdf: moon.urdf\n").find("urdf 'moon.urdf' not found"), std::string::npos);
  EXPECT_NE(complaint("- 1\n").find("expected a map"), std::string::npos);
  EXPECT_NE(complaint("spacing: wide\n" + good).find(":1: 'spacing' cannot be read"), std::string::npos);
  EXPECT_NE(
      complaint("urdf: table.urdf\nbodies:\n  - {name: a, material: jelly, shape: box, size: [1, 1, 1]}\n")
          .find(":3: material 'jelly' not found, expected a file or one of: bread_dough"),
      std::string::npos);
  EXPECT_NE(complaint("urdf: table.urdf\nbodies:\n  - {name: a, material: dough, shape: box, size: [1, 1]}\n")
                .find("'size' has 2 numbers"),
            std::string::npos);
  EXPECT_NE(
      complaint("urdf: table.urdf\nbodies:\n  - {name: a, material: dough, shape: star, size: [1, 1, 1]}\n")
          .find("expected box, cylinder, sphere or mesh"),
      std::string::npos);
}

TEST(Scene, NumbersAreFiniteAndInTheirRange) {
  const auto body = [](const std::string& rest) {
    return "urdf: table.urdf\nbodies:\n  - {name: a, material: dough, shape: box, " + rest + "}\n";
  };
  const std::string box = "size: [0.02, 0.02, 0.02]";
  const std::string rod =
      "urdf: table.urdf\nbodies:\n  - {name: a, material: dough, shape: cylinder, size: [1.0e-4, 1.0e-4, ";
  const std::string wheel = "urdf: potters_wheel.urdf\n" + good.substr(good.find('\n') + 1) + "motions:\n";
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {body(box + ", pose: [.nan, 0, 0, 0, 0, 0]"), ":3: 'pose' is not finite"},
      {body(box + ", velocity: [0, .inf, 0]"), ":3: 'velocity' is not finite"},
      {body(box + ", velocity: [0, 0, -1.0e39]"), ":3: 'velocity' of body 'a' is out of its range"},
      {body(box + ", color: [.nan, 0, 0]"), ":3: 'color' is not finite"},
      {body(box + ", pose: [3, 0, 0, 0, 0, 0]"), ":3: body 'a' reaches out of the world"},
      {body("size: [1e9, 1e9, 1e9]"), ":3: body 'a' makes more than 10000000 particles"},
      {rod + "1.0e7]}\n", ":3: body 'a' makes more than 10000000 particles"},
      {rod + "1.0e4]}\n", ":3: body 'a' reaches out of the world"},
      {"spacing: 1.0e-9\n" + good, ":4: body 'a' makes more than 10000000 particles"},
      {"spacing: 2\n" + good, "'spacing' is out of its range"},
      {"gravity: [0, 0, .nan]\n" + good, ":1: 'gravity' is not finite"},
      {"world: -1\n" + good, "'world' is out of its range"},
      {"tolerance: .inf\n" + good, ":1: 'tolerance' is not finite"},
      {"tolerance: -1\n" + good, "'tolerance' is out of its range"},
      {wheel + "  - {joint: wheel_joint, velocity: .nan}\n", ":5: 'velocity' is not finite"},
      {wheel + "  - {joint: wheel_joint, velocity: 1e308}\n", "expected at most 100 rad/s or m/s"},
      {wheel + "  - {joint: wheel_joint, velocity: 1, duration: .nan}\n", ":5: 'duration' is no number"},
      {wheel + "  - {joint: wheel_joint, velocity: 1, start: -1}\n", ":5: 'start' or 'duration'"},
      {wheel + "  - {joint: wheel_joint, velocity: 1}\n  - {joint: wheel_joint, velocity: 2}\n",
       ":6: motions of joint 'wheel_joint' overlap"}};
  for (const auto& [yaml, words] : wrong)
    EXPECT_NE(complaint(yaml).find(words), std::string::npos) << yaml << complaint(yaml);
  EXPECT_EQ(complaint(wheel + "  - {joint: wheel_joint, velocity: 1, duration: .inf}\n"), "");
}

TEST(Scene, KeysAreNamesAndStandThereOnce) {
  EXPECT_NE(complaint("spacing: 0.005\nspacing: 0.01\n" + good).find(":2: key 'spacing' stands there twice"),
            std::string::npos);
  EXPECT_NE(complaint("? [a, b]\n: 1\n" + good).find(".yaml:1: a key that is no name"), std::string::npos);
}

TEST(Scene, ComplaintsAreOneLineWhateverTheTextHas) {
  const std::string two_lines = "\"moon\\nstone\"",
                    body = "bodies:\n  - {name: a, shape: box, size: [1, 1, 1], ";
  for (const std::string& text : std::vector<std::string>{
           "urdf: " + two_lines + "\n", "urdf: \"package://moon\\nstone/a.urdf\"\n",
           good + two_lines + ": 1\n", "urdf: table.urdf\n" + body + "material: " + two_lines + "}\n"}) {
    const std::string words = complaint(text);
    EXPECT_NE(words.find("moon stone"), std::string::npos) << words;
    EXPECT_EQ(words.find('\n'), std::string::npos) << words;
  }
}

TEST(Quality, ThePapersSchemeIsAPreset) {
  const clay::Budget paper = loadQuality("paper", share);
  EXPECT_EQ(paper.method, clay::Method::paper);
  EXPECT_EQ(paper.substeps, 1);  // one step of 1/60 s
  EXPECT_EQ(loadQuality("balanced", share).method, clay::Method::minimise);
}

TEST(Quality, PresetsSpendMoreForMore) {
  const clay::Budget fast = loadQuality("fast", share), balanced = loadQuality("balanced", share),
                     accurate = loadQuality("accurate", share);
  EXPECT_LT(fast.substeps * fast.iterations, balanced.substeps * balanced.iterations);
  EXPECT_LT(balanced.substeps * balanced.iterations, accurate.substeps * accurate.iterations);
  try {
    loadQuality("best", share);
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(),
                 "quality 'best' not found, expected one of: draft, fast, balanced, accurate, paper");
  }
}

}  // namespace
}  // namespace tactile_clay::scene::scene_test
