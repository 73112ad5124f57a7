#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace tactile_clay::tools {

/// The package's folder that contains config/scenes: a folder above the program, or share/tactile_clay in
/// such a folder.
/// @param given the user's choice; it is returned unless it is empty
/// @throws std::runtime_error if there is none
inline std::string shareFolder(const std::string& given) {
  namespace fs = std::filesystem;
  if (!given.empty()) return given;
  std::error_code ignored;
  for (fs::path at = fs::read_symlink("/proc/self/exe", ignored); at.has_relative_path();
       at = at.parent_path()) {
    for (const fs::path& share : {at, at / "share" / "tactile_clay"}) {
      if (fs::is_directory(share / "config" / "scenes", ignored)) return share.string();
    }
  }
  throw std::runtime_error(
      "no folder above this program has config/scenes, expected the folder of the package there, or as an "
      "argument");
}

}  // namespace tactile_clay::tools
