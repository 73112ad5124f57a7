#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <std_msgs/Header.h>
#include <tactile_clay/ClayStatus.h>

#include <cstddef>
#include <cstdint>

#include "clay/clay.h"

namespace tactile_clay::nodes {

/// How the clay keeps up with the clock, and what of it is worth telling.
class ClayReport {
 public:
  ClayReport() { restart(); }

  /// The clay begins anew.
  void restart();
  /// After each frame.
  /// @param duration s, simulated
  /// @param dropped s before it, never to be simulated
  /// @param computing s, that it took
  void frame(const clay::Clay& clay, double duration, double dropped, double computing);

  /// `quality` and `lowered` are left for the caller.
  ClayStatus status(const clay::Clay& clay, const std_msgs::Header& header) const;
  /// Of the time since the last call.
  /// @return whether it was late, which the summary tells then
  bool diagnose(const clay::Clay& clay, diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  double simulated_ = 0.0, dropped_ = 0.0, busy_ = 0.0;  // s, since the last diagnostics
  std::uint64_t told_rejected_ = 0;                      // displacements
  std::size_t told_strays_ = 0;
  double real_time_factor_ = 1.0;
  ros::WallTime factor_since_;
  double factor_time_ = 0.0;  // s, simulated since then
};

}  // namespace tactile_clay::nodes
