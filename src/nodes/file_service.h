#pragma once

#include <exception>
#include <stdexcept>
#include <string>

#include "nodes/throttle.h"

namespace tactile_clay::nodes {

/// A node has a working folder of its own, which is not that of who calls.
/// @param what the file is
/// @throws std::runtime_error with one line where the name is not an absolute path
inline void requireAbsolute(const std::string& what, const std::string& file) {
  if (file.empty() || file.front() != '/')
    throw std::runtime_error(what + " '" + file + "', expected an absolute path");
}

/// Answers a service that works with a file.
/// @param work returns what is told of its success; what it throws is told as the reason of its failure, with
/// the service that replaces a file where there is one already
template <typename Response, typename Work>
void answer(Response& response, const Work& work) {
  try {
    response.message = work();
    response.success = true;
  } catch (const std::exception& error) {
    response.message = printableLine(error.what());
    if (response.message.find("is there already") != std::string::npos)
      response.message += ", or a call of the service overwrite";
  }
}

}  // namespace tactile_clay::nodes
