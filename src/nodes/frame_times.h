#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include <algorithm>

namespace tactile_clay::nodes {

/// Number of frames since the last report, and the time that they took, s.
struct FrameTimes {
  unsigned frames = 0;
  double sum = 0.0, longest = 0.0;

  void add(double seconds) {
    ++frames;
    sum += seconds;
    longest = std::max(longest, seconds);
  }

  /// Mean per frame of a sum over all frames; 0 without a frame.
  double mean(double of_all) const { return frames > 0 ? of_all / frames : 0.0; }

  /// Reports number and mean.
  void report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
    status.add("frames", frames);
    status.add("time for a frame, mean, ms", 1e3 * mean(sum));
  }
};

}  // namespace tactile_clay::nodes
