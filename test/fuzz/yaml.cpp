// YAML: a scene, and the same text as a material. The scene is filled coarsely, so that a large body is no
// large work.
#include <stdexcept>

#include "fuzz/fuzz.h"
#include "scene/scene.h"

namespace tactile_clay::fuzz {

std::vector<std::string> seeds() {
  const std::string config = std::string(TACTILE_CLAY_SOURCE_DIR) + "/config/";
  std::vector<std::string> all;
  for (const char* name : {"scenes/kindergarten.yaml", "scenes/potters_wheel.yaml", "materials/putty.yaml"})
    all.push_back(readFile(config + name));
  return all;
}

}  // namespace tactile_clay::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile_clay;
  constexpr double coarse = 0.05;  // m
  const std::string file = fuzz::asFile(data, size);
  try {
    scene::loadScene(file, TACTILE_CLAY_SOURCE_DIR, coarse);
  } catch (const std::runtime_error& error) {
    fuzz::expectOneLine(error.what());
  }
  try {
    scene::loadMaterial(file, TACTILE_CLAY_SOURCE_DIR);
  } catch (const std::runtime_error& error) {
    fuzz::expectOneLine(error.what());
  }
  return 0;
}
