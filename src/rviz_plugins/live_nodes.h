#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rviz_plugins/live_values.h"

namespace tactile_clay::rviz_plugins {

/// The nodes that have live parameters: the master knows their topics, and these have the parameters and
/// their values. A master that does not answer must not stop the window, so it is asked in a thread of its
/// own. Messages are taken in the thread that draws.
class LiveNodes {
 public:
  LiveNodes();

  /// Looks for nodes anew, unless a look is in progress.
  /// @param space namespace in which they are, such as `/`
  void look(const std::string& space);

  /// Parameters by full name of their node.
  std::map<std::string, std::vector<LiveParameter>> parameters() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // shared with a thread that may outlive this object
};

}  // namespace tactile_clay::rviz_plugins
