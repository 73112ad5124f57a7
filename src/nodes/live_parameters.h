#pragma once

#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/ros.h>

#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "nodes/settings.h"

namespace tactile_clay::nodes {

/// In the log line of a refused change: between the full name of the node and the reason.
constexpr char no_change[] = ": no parameter was changed: ";

/// Parameters of a node that may change while it runs, by dynamic_reconfigure: `~set_parameters` asks for
/// other values, `~parameter_descriptions` and `~parameter_updates` (both latched) publish the parameters and
/// their present values.
///
/// A change is checked as soon as it is asked for, by the function that read the parameters at the start. A
/// wrong change is refused with the same line, and nothing changes. A change applies as a whole from the next
/// frame on: `begin` applies it, and publishes it on `rig/changes` with the stamp of that frame. `~changes`
/// is a text of such changes, which are applied at their frames, so that a recorded run can be repeated with
/// them. Present values are written to the parameter server within a second, so that a node that is started
/// again begins with them.
class LiveParameters {
 public:
  /// Applies the values that were read. Must not throw for values that the reading function accepted.
  using Apply = std::function<void()>;
  /// Reads and checks all parameters.
  /// @throws std::exception with one line if one is wrong
  using Read = std::function<Apply(Settings&)>;

  /// Reads the parameters from the server and applies them.
  /// @throws what `read` throws, and std::runtime_error if `~changes` cannot be read
  LiveParameters(ros::NodeHandle nh, ros::NodeHandle private_nh, Read read);

  /// To be called before each frame, by the thread that computes it.
  /// @param stamp of the frame
  void begin(ros::Time stamp);

  /// Asks for other values as `~set_parameters` does, but from within the node.
  /// @throws what `read` throws
  void change(const SettingValues& values);

 private:
  struct Change {
    ros::Time stamp;     // stamp of the first frame with these values
    std::string values;  // a map in YAML
  };
  struct Pending {
    SettingValues values;
    Apply apply;
  };

  bool reconfigure(dynamic_reconfigure::Reconfigure::Request& request,
                   dynamic_reconfigure::Reconfigure::Response& response);
  void readChanges(const std::string& text);
  SettingValues fromYaml(const std::string& text) const;
  [[noreturn]] void refuseName(const std::string& name, const SettingValues& known) const;
  void ask(const SettingValues& values);
  void store();
  void tell(const SettingValues& before, ros::Time stamp);

  std::string node_;   // its name within the rig
  std::string space_;  // its full name
  Settings::Naming naming_;
  Read read_;
  std::mutex mutex_;
  std::vector<Setting> settings_;  // with the ranges for changes
  SettingValues values_;           // present values
  std::optional<Pending> pending_;
  std::deque<Change> changes_;  // to be applied at their frames
  ros::NodeHandle private_nh_;
  // Values on the parameter server; the default of the node if the server has none.
  SettingValues stored_;
  ros::Publisher descriptions_, updates_, told_;
  ros::ServiceServer server_;
  ros::WallTimer timer_;
};

}  // namespace tactile_clay::nodes
