#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "files/input_file.h"

namespace tactile_clay::files {

/// Limits for the work of a library on one file.
struct Bounds {
  std::chrono::seconds time{20};  // of processor time; of wall-clock time twice as much
  std::uint64_t memory = gibibyte;
};

/// Does work in a separate process, for libraries that trust the files which they read. That process may
/// crash, run without end or ask for all memory, without harm to this process. Changes that the work makes to
/// variables are lost.
/// @param work may throw std::exception; its text is thrown again
/// @return the result of the work
/// @throws std::runtime_error with the text that the work threw, or "crashes ...", "takes more than ..."
std::string runApart(const std::function<std::string()>& work, const Bounds& bounds = {});

}  // namespace tactile_clay::files
