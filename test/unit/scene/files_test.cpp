#include "scene/files.h"

#include "scene/scene.h"
#include "scene/text_file.h"
#include "support/error_of.h"
#include "support/scratch_folder.h"

#include <sys/stat.h>

namespace tactile_clay::scene::files_test {
namespace {

namespace fs = std::filesystem;
const std::string share = TACTILE_CLAY_SHARE;

class Files : public ScratchFolder {
 protected:
  std::string writeScene(const std::string& name, const std::string& material) const {
    fs::create_directories((folder / name).parent_path());
    return write(name, "urdf: table.urdf\nbodies:\n  - {name: a, material: '" + material +
                           "', shape: box, size: [0.02, 0.02, 0.02]}\n");
  }
  void writeMaterial(const std::string& name, double density) const {
    fs::create_directories((folder / name).parent_path());
    write(name, "density: " + std::to_string(density) + "\nbulk_modulus: 5000\nstiffness: 9000\n");
  }
  FindPackage lab() const {
    return
        [this](const std::string& name) { return name == "lab" ? (folder / "lab").string() : std::string(); };
  }
};

TEST_F(Files, AMaterialIsFoundBesideItsSceneFromAnyFolder) {
  writeMaterial("scenes/mud.yaml", 1501.0);
  writeMaterial("shared stuff/mud.yaml", 1502.0);
  writeMaterial("lab/mud.yaml", 1503.0);
  const std::vector<std::pair<std::string, double>> named = {
      {"mud.yaml", 1501.0},
      {"mud", 1501.0},
      {"./mud.yaml", 1501.0},
      {"../shared stuff/mud.yaml", 1502.0},
      {(folder / "shared stuff/mud.yaml").string(), 1502.0},
      {"file://" + (folder / "shared%20stuff/mud.yaml").string(), 1502.0},
      {"package://lab/mud.yaml", 1503.0},
      {"dough", loadScene(writeScene("scenes/of_dough.yaml", "dough"), share).materials[0].density},
      {"dough.yaml", loadScene(writeScene("scenes/of_dough.yaml", "dough"), share).materials[0].density}};
  for (const auto& [name, density] : named)
    EXPECT_EQ(loadScene(writeScene("scenes/scene.yaml", name), share, 0.0, lab()).materials[0].density,
              density)
        << name;
}

TEST_F(Files, HomeIsTheFolderOfTheUser) {
  writeMaterial("mud.yaml", 1504.0);
  const char* home = std::getenv("HOME");
  const std::string before = home == nullptr ? "" : home;
  setenv("HOME", folder.c_str(), 1);
  EXPECT_EQ(loadScene(writeScene("scenes/scene.yaml", "~/mud.yaml"), share).materials[0].density, 1504.0);
  home == nullptr ? unsetenv("HOME") : setenv("HOME", before.c_str(), 1);
}

TEST_F(Files, WhatIsNotFoundIsNamedWithTheLine) {
  const auto of = [&](const std::string& name) {
    return errorOf([&] { loadScene(writeScene("scenes/scene.yaml", name), share, 0.0, lab()); });
  };
  EXPECT_NE(of("mud.yaml").find("scene.yaml:3: material 'mud.yaml' not found"), std::string::npos)
      << of("mud.yaml");
  EXPECT_NE(of("mud.yaml").find(folder.string()), std::string::npos) << of("mud.yaml");
  EXPECT_NE(of("../mud.yaml").find("there is no file " + folder.string()), std::string::npos)
      << of("../mud.yaml");
  EXPECT_NE(of("package://moon/mud.yaml").find("package 'moon' is not known"), std::string::npos);
  EXPECT_NE(of("https://example.org/mud.yaml").find("expected a path, file:// or package://"),
            std::string::npos);
}

TEST_F(Files, OnlyRegularFilesAreRead) {
  const std::string pipe = (folder / "pipe.yaml").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(errorOf([&] { readText(pipe); }).find("is a FIFO"), std::string::npos);
  EXPECT_NE(errorOf([&] { loadScene(pipe, share); }).find("not found"), std::string::npos);
}

TEST_F(Files, TextIsUtf8) {
  EXPECT_EQ(readText(write("a", "\xef\xbb\xbfT\xc3\xb6pfe \xe2\x82\xac\n")), "T\xc3\xb6pfe \xe2\x82\xac\n");
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"a: 1\n# T\xf6pfe\n", "a:2: bytes that are no UTF-8"},
      {"\xff\xfe"
       "a\0:\0",
       "a: is UTF-16"},
      {std::string("a\0b", 3), "a:1: a control character"},
      {"a: \x1b[0m\n", "a:1: a control character"},
      {"\xc0\xaf", "a:1: bytes that are no UTF-8"},
      {"\n\xe2\x82", "a:2: bytes that are no UTF-8"}};
  for (const auto& [text, words] : wrong) {
    const std::string file = write("a", text);
    const std::string said = errorOf([&] { readText(file); });
    EXPECT_NE(said.find(words), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace tactile_clay::scene::files_test
