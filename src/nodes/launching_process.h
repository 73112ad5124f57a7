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
  /// Of this process. Nothing where it was started by hand.
  static std::unique_ptr<LaunchingProcess> find();

  /// @param process its number; where there is none of that number, it is gone from the start
  explicit LaunchingProcess(pid_t process);

  /// Gone at once when it is dead; frozen when it was stopped for `silence_times::supervisor_patience`.
  std::string missing() override;

  /// Address of the roslaunch on another host that had this process launched; empty: there is none.
  std::string server() const;

 private:
  using Clock = std::chrono::steady_clock;

  pid_t process_;
  std::uint64_t start_ = 0;  // s/100 since the computer started: processes of one number differ in it
  std::optional<Clock::time_point> stopped_since_;
};

}  // namespace tactile_clay::nodes
