// Files of saved clay.
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "clay/sculpture.h"
#include "fuzz/fuzz.h"

namespace tactile_clay::fuzz {

std::vector<std::string> seeds() {
  constexpr std::size_t particles = 3;
  clay::Sculpture sculpture;
  sculpture.time = 1.0;
  sculpture.spacing = 0.005;
  sculpture.material.assign(particles, 0);
  sculpture.body.assign(particles, 0);
  sculpture.compression.assign(particles, 1.0f);
  sculpture.sleep.lump.assign(particles, 0);
  for (clay::VectorField* field :
       {&sculpture.position, &sculpture.velocity, &sculpture.window_start, &sculpture.sleep.mark}) {
    field->resize(particles);
    for (std::size_t i = 0; i < particles; ++i)
      field->set(i, Eigen::Vector3f(0.005f * static_cast<float>(i), 0.0f, 0.0f));
  }
  sculpture.bond_begin = {0, 1, 2, 2};
  sculpture.bonds = {{1, 0.005f}, {2, 0.005f}};
  clay::Contact contact{};
  contact.normal = Eigen::Vector3f::UnitZ();
  sculpture.contacts = {contact};
  const auto file =
      std::filesystem::temp_directory_path() / ("tactile_clay_fuzz_" + std::to_string(::getpid()) + ".clay");
  clay::save(sculpture, file.string());
  clay::loadSculpture(file.string());  // it is a right one
  const std::string saved = readFile(file.string());
  std::filesystem::remove(file);
  return {saved};
}

}  // namespace tactile_clay::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile_clay;
  try {
    clay::loadSculpture(fuzz::asFile(data, size));
  } catch (const std::runtime_error& error) {
    fuzz::expectOneLine(error.what());
  }
  return 0;
}
