#pragma once

#include <functional>
#include <vector>

#include "clay/clay.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "tools/hand_samples.h"

namespace tactile_clay::tools {

/// What a stretch of a long kneading cost, and on what. Means over its frames, but where it says otherwise.
struct Stretch {
  double end = 0.0;               // s, simulated
  double ms = 0.0, ms_p99 = 0.0;  // of a frame: median, 99th percentile
  double yardstick_ms = 0.0;      // median of the yardstick's frames at the end of the stretch
  double cpu_ms = 0.0;            // of all threads, a frame: what other programs take does not count
  double dropped = 0.0;           // s that a live run did not simulate
  double awake = 0.0, contacts = 0.0, iterations = 0.0, rounds = 0.0, lumps = 0.0, crumbs = 0.0;
  double bonds = 0.0, neighbours = 0.0;  // of a particle, at the end
  double volume = 0.0;                   // m^3, at the end (volumeOf)
  std::size_t strays = 0;                // at the end
  std::vector<clay::Stage> stages;       // ms of a frame, mean
  double memory = 0.0;                   // MB, resident, at the end
};

/// How long, and how, hands go on with what they do.
struct LongKneading {
  double duration = 60.0;  // s, simulated
  double stretch = 10.0;   // s
  /// Frames last as long as the wall clock says, and time that the computer has no room for is dropped;
  /// otherwise in lockstep, and the same on every run.
  bool live = false;
  /// Above 0 a live run has the clock of a computer on which each frame takes so many times what it
  /// simulates, and is the same on every run.
  double slowness = 0.0;
};

/// Plays what hands do again and again, each time from where the clay is, and tells of each stretch.
///
/// Computers get slower and faster from minute to minute. So after each stretch the same second of clay, the
/// first one of the run, is played once more: what it takes is the yardstick for the stretch.
/// @param samples one pass of the hands, as of `handSamples`
void kneadLong(const scene::Scene& scene, const scene::Solids& solids, const std::vector<HandSample>& samples,
               const LongKneading& how, const std::function<void(const Stretch&)>& tell);

}  // namespace tactile_clay::tools
