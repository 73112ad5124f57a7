#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tactile_clay::rviz_plugins {

/// Runs calls that wait for other processes, each in a thread of its own: a service or a master that does not
/// answer must not stop the window. The results wait for the thread that draws.
class ServiceCalls {
 public:
  using Call = std::function<bool(std::string& answer)>;  // returns whether it succeeded
  struct Answer {
    std::string text;
    bool good;
  };
  /// Facts about the rig that no topic publishes.
  struct Rig {
    std::string scene;        // scene with which the clay was started
    bool has_undo = false;    // whether the clay offers the service
    bool has_export = false;  // whether its surface offers the service
  };

  ServiceCalls();

  /// @param what first words of the answer
  /// @return false if the call before it is not answered yet
  bool start(const std::string& what, Call work);
  /// The answers since the last call.
  std::vector<Answer> take();

  /// The facts that were found last.
  Rig rig() const;
  /// Looks for them anew, unless a look is in progress.
  /// @param clay, surface full names of the nodes that simulate the clay and make its surface
  void lookAtRig(const std::string& clay, const std::string& surface);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // shared with threads that may outlive this object
};

}  // namespace tactile_clay::rviz_plugins
