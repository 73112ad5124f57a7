#pragma once

#include <stdexcept>
#include <string>

namespace tactile_clay {

/// What a call says where it throws an Error; empty where it throws nothing.
template <typename Error = std::runtime_error, typename Call>
std::string errorOf(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace tactile_clay
