#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "clay/sculpture.h"

namespace tactile_clay::nodes {

/// Writes the clay to a file, whole each time, in a thread of its own: who hands it over does not wait for
/// the disk. What cannot be written is warned of.
class Checkpoint {
 public:
  explicit Checkpoint(std::string file);
  /// Does not write any more what is waiting.
  ~Checkpoint();

  /// Of several that wait the newest is written.
  void keep(clay::Sculpture clay);

 private:
  void run();

  const std::string file_;
  std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  std::optional<clay::Sculpture> waiting_;
  bool ending_ = false;

  std::thread thread_;
};

}  // namespace tactile_clay::nodes
