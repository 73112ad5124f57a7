#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "files/input_file.h"

namespace tactile_clay::files {

/// What a library may take for a file.
struct Bounds {
  std::chrono::seconds time{20};  // of a processor, and twice that of the clock
  std::uint64_t memory = gibibyte;
};

/// For libraries that trust the files which they read: does the work in a process of its own, which may
/// crash, never end or ask for all memory, and harms nobody. What it changes elsewhere is lost.
/// @param work may throw std::exception; its words are thrown again
/// @return what the work returns
/// @throws std::runtime_error with the words of the work, or "crashes ...", "takes more than ..."
std::string runApart(const std::function<std::string()>& work, const Bounds& bounds = {});

}  // namespace tactile_clay::files
