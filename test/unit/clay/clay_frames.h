#pragma once

#include <cstring>
#include <vector>

#include "clay/clay.h"
#include "support/setups.h"

/// Frames of small blocks of clay, and a comparison to the bit.
namespace tactile_clay::clay::clay_frames {

constexpr double spacing = 0.005;

inline ClayConfig configOf(int substeps = 4, int iterations = 8) {
  ClayConfig config;
  config.spacing = spacing;
  config.budget = {substeps, iterations};
  config.threads = 1;
  config.sleeping = false;  // what is asleep cannot fail
  return config;
}

inline void run(Clay& clay, int frames, const Skin& samples = {}, const std::vector<Solid>& solids = {}) {
  for (int k = 0; k < frames; ++k) clay.advance(samples, solids, clay.config().frame);
}

inline bool sameBits(const VectorField& a, const VectorField& b) {
  return a.size() == b.size() && std::memcmp(&a[0], &b[0], a.size() * sizeof(a[0])) == 0;
}

}  // namespace tactile_clay::clay::clay_frames
