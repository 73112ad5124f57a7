#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <std_msgs/Header.h>
#include <tactile_clay/ClayStatus.h>

#include <cstddef>
#include <cstdint>

#include "clay/clay.h"

namespace tactile_clay::nodes {

/// Measures how the clay keeps up with the clock, and reports it.
class ClayReport {
 public:
  ClayReport() { restart(); }

  /// To be called when the clay begins anew.
  void restart();
  /// To be called after each frame.
  /// @param duration s, simulated
  /// @param dropped s before this frame that will never be simulated
  /// @param computing s that the computation took
  void frame(const clay::Clay& clay, double duration, double dropped, double computing);

  /// The caller has to set `quality` and `lowered`.
  ClayStatus status(const clay::Clay& clay, const std_msgs::Header& header) const;
  /// Reports on the time since the last call.
  /// @return whether the clay was late; the summary then contains this
  bool diagnose(const clay::Clay& clay, diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  double simulated_ = 0.0, dropped_ = 0.0, busy_ = 0.0;  // s, since the last diagnostics
  std::uint64_t told_rejected_ = 0;                      // rejected displacements that were logged
  std::size_t told_strays_ = 0;
  double real_time_factor_ = 1.0;
  ros::WallTime factor_since_;
  double factor_time_ = 0.0;  // s, simulated since `factor_since_`
};

}  // namespace tactile_clay::nodes
