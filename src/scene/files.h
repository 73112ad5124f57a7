#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace tactile_clay::scene {

/// Folder of a ROS package by its name; empty where it is not known.
using FindPackage = std::function<std::string(const std::string& package)>;

/// The path that a file key means: absolute, `~/...`, `file:///...`, `package://NAME/...`, or relative to the
/// folder of the file in which the key stands. Whether there is such a file is not looked at.
/// @throws std::runtime_error where the package is not known, or for another kind of address
std::filesystem::path pathOf(const std::string& name, const std::filesystem::path& folder,
                             const FindPackage& find_package = {});

/// A file by its path, or by its name in a folder of the package.
/// @param kind what it is, for errors
/// @param beside folder of the file that names it
/// @param shipped folder of the package, whose files end with `ending`
/// @throws std::runtime_error with one line that names the files of the package
std::string findFile(const std::string& kind, const std::string& name, const std::filesystem::path& beside,
                     const std::filesystem::path& shipped, const std::string& ending,
                     const FindPackage& find_package = {});

}  // namespace tactile_clay::scene
