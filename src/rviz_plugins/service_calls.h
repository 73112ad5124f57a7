#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tactile_clay::rviz_plugins {

/// Work that waits for others, each in a thread of its own: a service or a master that does not answer must
/// not stop the window. What came of it waits for the thread that draws.
class ServiceCalls {
 public:
  using Call = std::function<bool(std::string& answer)>;  // returns whether it succeeded
  struct Answer {
    std::string text;
    bool good;
  };
  /// What no topic tells of the rig.
  struct Rig {
    std::string scene;        // as the clay was started with it
    bool has_undo = false;    // whether the clay serves it
    bool has_export = false;  // whether its surface does
  };

  ServiceCalls();

  /// @param what the answer begins with
  /// @return false where the one before it is not answered yet
  bool start(const std::string& what, Call work);
  /// The answers since the last call.
  std::vector<Answer> take();

  /// What was found last of the rig.
  Rig rig() const;
  /// Looks for it anew, unless it does.
  /// @param clay, surface full names of the nodes that simulate the clay and make its surface
  void lookAtRig(const std::string& clay, const std::string& surface);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // with threads that may outlive this
};

}  // namespace tactile_clay::rviz_plugins
