#pragma once

#include <functional>
#include <vector>

#include "clay/clay.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "tools/hand_samples.h"

namespace tactile_clay::tools {

/// Costs of a stretch of a long kneading. Means over its frames, unless a comment says otherwise.
struct Stretch {
  double end = 0.0;               // s, simulated
  double ms = 0.0, ms_p99 = 0.0;  // of a frame: median, 99th percentile
  double yardstick_ms = 0.0;      // median of the yardstick's frames at the end of the stretch
  double cpu_ms = 0.0;            // of all threads, per frame; time of other programs does not count
  double dropped = 0.0;           // s that a live run did not simulate
  double touched = 0.0;           // skin samples that the clay presses
  double awake = 0.0, contacts = 0.0, iterations = 0.0, rounds = 0.0, lumps = 0.0, crumbs = 0.0;
  double bonds = 0.0, neighbours = 0.0;  // per particle, at the end
  double volume = 0.0;                   // m^3, at the end (volumeOf)
  std::size_t strays = 0;                // at the end
  std::vector<clay::Stage> stages;       // ms per frame, mean
  double memory = 0.0;                   // MB, resident, at the end
};

/// How long and in which way hands repeat what they do.
struct LongKneading {
  double duration = 60.0;  // s, simulated
  double stretch = 10.0;   // s
  /// True: frames last as long as on the wall clock, and time that the computer cannot simulate is dropped.
  /// False: in lockstep, and the same on every run.
  bool live = false;
  /// Above 0, a live run has the clock of a computer on which a frame takes `slowness` times its simulated
  /// time, and is the same on every run.
  double slowness = 0.0;
};

/// Plays what hands do again and again, each time with the clay as it is, and reports each stretch.
///
/// Computers get slower and faster from minute to minute. So after each stretch the first second of the run
/// is played once more. Its duration is the yardstick for the stretch.
/// @param samples one pass of the hands, as from `handSamples`
void kneadLong(const scene::Scene& scene, const scene::Solids& solids, const std::vector<HandSample>& samples,
               const LongKneading& how, const std::function<void(const Stretch&)>& tell);

}  // namespace tactile_clay::tools
