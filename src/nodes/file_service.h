#pragma once

#include <exception>
#include <stdexcept>
#include <string>

#include "values/text.h"

namespace tactile_clay::nodes {

/// Requires an absolute path: the working folder of a node is not that of the caller.
/// @param what kind of the file, for the error line
/// @throws std::runtime_error with one line if the name is not an absolute path
inline void requireAbsolute(const std::string& what, const std::string& file) {
  if (file.empty() || file.front() != '/')
    throw std::runtime_error(what + " '" + file + "', expected an absolute path");
}

/// Answers a service that works with a file.
/// @param work returns the message of its success. The text of an exception that it throws becomes the
/// message of its failure. If the file exists already, that message also names the service that replaces it
template <typename Response, typename Work>
void answer(Response& response, const Work& work) {
  try {
    response.message = work();
    response.success = true;
  } catch (const std::exception& error) {
    response.message = values::printableLine(error.what());
    if (response.message.find("exists already") != std::string::npos)
      response.message += ", or a call of the service overwrite";
  }
}

}  // namespace tactile_clay::nodes
