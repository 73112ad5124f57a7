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

/// A parameter, as the function that read it told it.
struct Setting {
  std::string name, group, meaning;
  SettingValue value, fallback;
  SettingValue low, high;            // of numbers; else as `value`
  std::vector<std::string> choices;  // of a text that has them
};

/// Where a function reads the parameters of a node from: the parameter server at the start, what was asked
/// for while the node runs, or a file. Each parameter is told once, where it is read, with its meaning and
/// the range that is checked; who shows parameters to people takes them from `read()`.
class Settings {
 public:
  /// How a parameter is called in lines about it.
  using Naming = std::function<std::string(const std::string& name)>;

  /// Those of the parameter server.
  explicit Settings(const ros::NodeHandle& private_nh);
  /// Those given, and for others what the reading function falls back to.
  Settings(Naming naming, SettingValues given);

  /// False where nothing runs yet.
  bool running() const { return !server_; }
  /// Those read from now on belong together.
  /// @param name empty: to no group
  void group(const std::string& name) { group_ = name; }

  /// @throws std::runtime_error with one line naming the parameter, its value and what was expected
  double number(const std::string& name, double fallback, double low, double high,
                const std::string& meaning);
  int whole(const std::string& name, int fallback, int low, int high, const std::string& meaning);
  bool truth(const std::string& name, bool fallback, const std::string& meaning);
  /// @param choices all that it may be; empty: the reading function knows
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

/// What a parameter of this type is, for people: "a number".
const char* kindOf(const SettingValue& value);

}  // namespace tactile_clay::nodes
