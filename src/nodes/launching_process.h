#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "nodes/supervisors.h"

namespace tactile_clay::nodes {

/// The process that launched this one: a roslaunch, or a program that uses its library.
class LaunchingProcess : public Supervisor {
 public:
  /// The process that launched this one; null if this one was started by hand.
  static std::unique_ptr<LaunchingProcess> find();

  /// @param process its number; if no process has it, the process counts as gone from the start
  explicit LaunchingProcess(pid_t process);

  /// Reports the process as gone at once when it is dead, and as frozen after it was stopped for
  /// `silence_times::supervisor_patience`.
  std::string missing() override;

  /// Address of the roslaunch on another host that had this process launched; empty: there is none.
  std::string server() const;

 private:
  using Clock = std::chrono::steady_clock;

  pid_t process_;
  // s/100 from the start of the computer to that of the process: it differs between processes of one number.
  std::uint64_t start_ = 0;
  std::optional<Clock::time_point> stopped_since_;
};

}  // namespace tactile_clay::nodes
