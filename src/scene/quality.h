#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "clay/clay.h"

namespace tactile_clay::scene {

/// The name by which a rig asks for a quality that its computer keeps up with.
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

/// Those among which `auto` chooses, the coarsest first: all that are solved by `Method::minimise`.
std::vector<Quality> steadyQualities(std::vector<Quality> all);

/// What `auto` chooses: the most accurate quality that holds the target.
/// @param ms that a frame took with each quality, the coarsest first. The last ones may be missing: they do
/// not hold.
/// @param target ms
/// @return its place; 0, the coarsest, where none holds
std::size_t mostAccurate(const std::vector<double>& ms, double target);

/// What is taken instead of a budget that costs too much: the most accurate quality that costs less; nothing
/// where there is none.
/// @param steady the coarsest first
const Quality* coarserThan(const clay::Budget& budget, const std::vector<Quality>& steady);

/// What to expect of it, in words.
std::string expectation(const Quality& quality);

/// What a rig asks for.
struct QualityWish {
  std::string quality = "balanced";  // a preset, or `automatic`
  double target_ms = 0.0;            // that a frame may take; 0: none
  bool lockstep = false;
  std::string solver;                // empty: the preset's
  int substeps = 0, iterations = 0;  // 0: the preset's
  /// Whether the computer has a say in the quality.
  bool adapts() const { return quality == automatic || target_ms > 0.0; }
};

/// @throws std::runtime_error with one line where the computer is to have a say and cannot: in lockstep, or
/// where substeps, iterations or another solver are given; and where the quality is not known
void requireQuality(const QualityWish& wish, const std::vector<Quality>& all);

}  // namespace tactile_clay::scene
