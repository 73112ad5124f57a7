#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "clay/clay.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "tools/accuracy_options.h"
#include "tools/accuracy_report.h"
#include "tools/hand_samples.h"
#include "tools/outcome.h"

namespace tactile_clay::tools {

/// One run of the clay.
struct Play {
  clay::Budget budget;
  std::size_t skin;  // index into the skins of the sweep
  int aside;         // axis along which the clay is moved by a micrometre; -1: none
  int number;        // number among the plays of all sweeps
  std::string what;  // budget in words, as in "minimise:4x8"
  double cost;       // relative, without a unit
};

/// Hands with skin samples at one distance.
struct SweepSkin {
  double distance;  // m
  std::vector<HandSample> samples;
};

/// All plays with clay and hands of one kind, in the order of the table.
struct Sweep {
  scene::Scene scene;
  std::unique_ptr<scene::Solids> solids;
  std::vector<SweepSkin> skins;  // the finest first
  PlayOptions how;
  Played played;
  std::string key;  // describes what is played, without a Play
  /// `reference`: with its own step, with half of it, and with half of it and the clay moved along x, y and
  /// z.
  std::vector<Play> settings, reference;
};

/// All sweeps of the options, one for each spacing, material and model of the hand.
std::vector<Sweep> sweepsOf(const AccuracyOptions& options);

/// Plays, or loads outcomes that were played before (--outcomes), and reports its progress on the standard
/// error.
class Player {
 public:
  /// @param sweeps all that may be played
  Player(AccuracyOptions options, const std::vector<Sweep>& sweeps);

  /// Whether this shard plays a play. Shards take turns, so that each has its part of the expensive plays.
  bool isMine(const Play& play) const { return play.number % options_.shards == options_.shard - 1; }

  /// @throws std::runtime_error if outcomes are only to be merged (--merge) and this outcome is missing
  Outcome operator()(const Sweep& sweep, const Play& play);

 private:
  std::string fileOf(const Sweep& sweep, const Play& play) const;
  void tell(const Sweep& sweep, const Play& play) const;

  AccuracyOptions options_;
  int count_ = 0, done_ = 0;
  double left_ = 0.0, played_ = 0.0;  // costs that are left, and that were played
  double seconds_ = 0.0;              // duration of the plays so far
};

}  // namespace tactile_clay::tools
