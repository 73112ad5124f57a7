#pragma once

#include <string>

namespace tactile_clay::nodes {

/// A parameter of dynamic_reconfigure, such as dynamic_reconfigure::IntParameter, with its name and value.
template <class Parameter, typename T>
Parameter namedValue(const std::string& name, const T& value) {
  Parameter made;
  made.name = name;
  made.value = value;
  return made;
}

}  // namespace tactile_clay::nodes
