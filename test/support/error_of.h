#pragma once

#include <stdexcept>
#include <string>

namespace tactile_clay {

/// What a call says where it throws a std::runtime_error; empty where it throws nothing.
template <typename Call>
std::string errorOf(const Call& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace tactile_clay
