#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "device/sonic_surface_drives.h"
#include "device/sonic_surface_protocol.h"

namespace tactile_clay::device::sonic_surface {

constexpr char self[] = "sonic_surface";  // how it begins its messages

/// The options of the device SonicSurface, which its class describes.
struct Settings {
  std::string path;  // of the port
  Boards boards;
  std::chrono::duration<double> hold{0.0}, wait{0.0};
  bool guarded = true;
  Playable array;
  std::vector<std::string> remarks;  // lines that the user should read
};

/// @throws std::runtime_error with one line if an option is missing or wrong, or if a file cannot be read
Settings settingsOf(const std::map<std::string, std::string>& options);

}  // namespace tactile_clay::device::sonic_surface
