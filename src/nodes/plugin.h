#pragma once

#include <pluginlib/class_loader.hpp>

#include <stdexcept>
#include <string>

namespace tactile_clay::nodes {

/// A plugin of a base class of this package, and the loader that must outlive it.
template <class Base>
class Plugin {
 public:
  /// @param base full name of Base, as plugin descriptions spell it
  /// @param what the thing in an error message, such as "device"
  /// @param name of a plugin; without a package it is one of this package
  /// @param also a name that is right elsewhere though it is no plugin, for the list of an error message
  /// @throws std::runtime_error listing the known plugins
  Plugin(const std::string& base, const std::string& what, const std::string& name,
         const std::string& also = "")
      : loader_("tactile_clay", base) {
    const std::string full = name.find('/') == std::string::npos ? "tactile_clay/" + name : name;
    if (!loader_.isClassAvailable(full)) {
      std::string known = also;
      for (const std::string& candidate : loader_.getDeclaredClasses())
        known +=
            (known.empty() ? "" : ", ") + candidate.substr(candidate.rfind("tactile_clay/", 0) == 0 ? 13 : 0);
      throw std::runtime_error("unknown " + what + " '" + name + "': expected one of " + known);
    }
    try {
      object_ = loader_.createUniqueInstance(full);
    } catch (const pluginlib::PluginlibException& error) {
      throw std::runtime_error(what + " '" + name + "' cannot be loaded: " + error.what());
    }
  }

  Base* operator->() const { return object_.get(); }
  Base& operator*() const { return *object_; }

 private:
  pluginlib::ClassLoader<Base> loader_;
  pluginlib::UniquePtr<Base> object_;
};

}  // namespace tactile_clay::nodes
