#pragma once

#include <ros/node_handle.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace tactile_clay::nodes {

using SettingValue = std::variant<bool, int, double, std::string>;
using SettingValues = std::map<std::string, SettingValue>;

/// A parameter, as the function that read it described it.
struct Setting {
  std::string name, group, meaning;
  SettingValue value, fallback;
  SettingValue low, high;            // range of a number; else of the type of `value`
  std::vector<std::string> choices;  // allowed values of a text; empty: no list
};

/// The source from which a function reads the parameters of a node: the parameter server at the start, the
/// values that were asked for while the node runs, or a file. Each parameter is described once, where it is
/// read, with its meaning and the range that is checked. `read()` returns the descriptions, for programs that
/// show parameters.
class Settings {
 public:
  /// The name of a parameter in log and error lines.
  using Naming = std::function<std::string(const std::string& name)>;

  /// Reads from the parameter server.
  explicit Settings(const ros::NodeHandle& private_nh);
  /// Reads from `given`. A parameter that is not there gets the fallback of the reading function.
  Settings(Naming naming, SettingValues given);

  /// False while parameters are read from the parameter server at the start.
  bool running() const { return !server_; }
  /// Parameters that are read from now on belong to this group.
  /// @param name name of the group; empty: none
  void group(const std::string& name) { group_ = name; }

  /// @throws std::runtime_error with one line naming the parameter, its value and what was expected
  double number(const std::string& name, double fallback, double low, double high,
                const std::string& meaning);
  int whole(const std::string& name, int fallback, int low, int high, const std::string& meaning);
  bool truth(const std::string& name, bool fallback, const std::string& meaning);
  /// @param choices the allowed values; empty: the caller checks the value itself
  std::string text(const std::string& name, const std::string& fallback, const std::string& meaning,
                   const std::vector<std::string>& choices = {});

  const std::vector<Setting>& read() const { return read_; }
  SettingValues values() const;
  std::string nameOf(const std::string& name) const { return naming_(name); }

 private:
  template <typename T>
  T take(const std::string& name, const T& fallback) const;
  template <typename T>
  T within(Setting setting);

  std::optional<ros::NodeHandle> server_;
  Naming naming_;
  SettingValues given_;
  std::string group_;
  std::vector<Setting> read_;
};

/// Name of the type of a parameter for error lines, such as "a number".
const char* kindOf(const SettingValue& value);

}  // namespace tactile_clay::nodes
