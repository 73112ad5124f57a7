#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clay/clay.h"

namespace tactile_clay::scene {

/// The name with which a rig asks for the best quality that its computer can compute in time.
constexpr char automatic[] = "auto";

/// How far a quality is from a reference of many small steps: doc/method/speed_accuracy.md.
struct ExpectedErrors {
  double force = 0.0;         // on hands, share of the reference's
  double displacement = 0.0;  // of the particles at the end, root mean square, spacings
};

/// A preset of config/quality.yaml.
struct Quality {
  std::string name;
  clay::Budget budget;
  ExpectedErrors kneading, wheel;
};

/// All presets of `<share>/config/quality.yaml`, in its order: from the coarsest to the most accurate, then
/// the paper's.
/// @throws std::runtime_error with one line: file, line, what was expected
std::vector<Quality> loadQualities(const std::string& share);

/// The qualities among which `auto` chooses, the coarsest first: all with `Method::minimise`.
std::vector<Quality> steadyQualities(std::vector<Quality> all);

/// The quality that `auto` chooses: the most accurate one that meets the target.
/// @param ms duration of a frame with each quality, the coarsest first. The last ones may be missing: they do
///   not meet the target.
/// @param target ms
/// @return its index; 0, the coarsest, if none meets the target
std::size_t mostAccurate(const std::vector<double>& ms, double target);

/// The replacement for a budget that costs too much: the most accurate quality that costs less; null if there
/// is none.
/// @param steady the coarsest first
const Quality* coarserThan(const clay::Budget& budget, const std::vector<Quality>& steady);

/// The errors to expect of a quality, in words.
std::string expectation(const Quality& quality);

/// What a rig asks for.
struct QualityWish {
  std::string quality = "balanced";  // a preset, or `automatic`
  double target_ms = 0.0;            // maximum duration of a frame; 0: none
  bool lockstep = false;
  std::string solver;                // empty: the preset's
  int substeps = 0, iterations = 0;  // 0: the preset's
  /// Whether the speed of the computer decides about the quality.
  bool adapts() const { return quality == automatic || target_ms > 0.0; }
};

/// @throws std::runtime_error with one line if the quality is not known; or if the speed of the computer is
///   to decide, but cannot: in lockstep, or if substeps, iterations or another solver than `minimise` are
///   given
void requireQuality(const QualityWish& wish, const std::vector<Quality>& all);

}  // namespace tactile_clay::scene
