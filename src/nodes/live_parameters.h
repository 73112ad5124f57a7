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

/// Parameters of a node that may change while it runs, by dynamic_reconfigure: `~set_parameters` asks for
/// other values, `~parameter_descriptions` and `~parameter_updates` (both latched) tell what there is and
/// what holds.
///
/// A change is checked as it comes, by the function that read the parameters at the start: what is wrong is
/// refused with the same line, and nothing changes. It holds from the next frame on, whole: `begin` applies
/// it, and tells it on `rig/changes` with the stamp of that frame. `~changes` is a text of such changes,
/// which are made at their frames: so a recorded run comes again with them. What holds goes to the parameter
/// server within a second: a node that is started again begins with it.
class LiveParameters {
 public:
  /// Makes what was read hold. Must not throw for what the reading function has let pass.
  using Apply = std::function<void()>;
  /// Reads and checks all parameters.
  /// @throws std::exception with one line where one is wrong
  using Read = std::function<Apply(Settings&)>;

  /// Reads the parameters from the server and applies them.
  /// @throws what `read` throws, and std::runtime_error where `~changes` cannot be read
  LiveParameters(ros::NodeHandle nh, ros::NodeHandle private_nh, Read read);

  /// To be called before each frame, by the thread that computes it.
  /// @param stamp of the frame
  void begin(ros::Time stamp);

  /// Asks for other values as `~set_parameters` does, for the node itself.
  /// @throws what `read` throws
  void change(const SettingValues& values);

 private:
  struct Change {
    ros::Time stamp;     // of the first frame for which it holds
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
  void ask(const SettingValues& values);
  void store();
  void tell(const SettingValues& before, ros::Time stamp);

  std::string node_;   // its name within the rig
  std::string space_;  // its full name
  Settings::Naming naming_;
  Read read_;
  std::mutex mutex_;
  std::vector<Setting> settings_;  // as they may change
  SettingValues values_;           // that hold
  std::optional<Pending> pending_;
  std::deque<Change> changes_;  // to be made at their frames
  ros::NodeHandle private_nh_;
  SettingValues stored_;  // on the parameter server, or what the node takes where nothing is there
  ros::Publisher descriptions_, updates_, told_;
  ros::ServiceServer server_;
  ros::WallTimer timer_;
};

}  // namespace tactile_clay::nodes
