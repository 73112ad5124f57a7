#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "clay/sculpture.h"

namespace tactile_clay::nodes {

/// Writes the clay to a file, each time the whole clay, in a thread of its own: the caller of `keep` does not
/// wait for the disk. If the file cannot be written, a warning is logged.
class Checkpoint {
 public:
  explicit Checkpoint(std::string file);
  /// A state that still waits is not written any more.
  ~Checkpoint();

  /// If several states wait, only the newest one is written.
  void keep(clay::Sculpture clay);

 private:
  void run();

  const std::string file_;
  std::mutex mutex_;  // protects `waiting_` and `ending_`
  std::condition_variable came_;
  std::optional<clay::Sculpture> waiting_;
  bool ending_ = false;

  std::thread thread_;
};

}  // namespace tactile_clay::nodes
