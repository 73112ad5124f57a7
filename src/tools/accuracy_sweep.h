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
  std::size_t skin;  // of the sweep's
  int aside;         // axis; -1: not
  int number;        // of all that are played
  std::string what;  // as in "minimise:4x8"
  double cost;       // in no unit
};

/// Hands whose skin has samples of one distance.
struct SweepSkin {
  double distance;  // m
  std::vector<HandSample> samples;
};

/// All that is played with clay and hands of one kind, in the order of the table.
struct Sweep {
  scene::Scene scene;
  std::unique_ptr<scene::Solids> solids;
  std::vector<SweepSkin> skins;  // the finest first
  PlayOptions how;
  Played played;
  std::string key;                        // of what is played, beside a Play
  std::vector<Play> settings, reference;  // reference: its step, half of it, and that aside along x, y, z
};

/// All sweeps of the options, one for each spacing, material and model of the hand.
std::vector<Sweep> sweepsOf(const AccuracyOptions& options);

/// Plays, or finds what was played before (--outcomes), and tells on the standard error how far it is.
class Player {
 public:
  /// @param sweeps all that may be played
  Player(AccuracyOptions options, const std::vector<Sweep>& sweeps);

  /// Whether a play is of this share. Shards take turns, so that each has its share of the dear ones.
  bool isMine(const Play& play) const { return play.number % options_.shards == options_.shard - 1; }

  /// @throws std::runtime_error where only what is there is to be merged, and this is not
  Outcome operator()(const Sweep& sweep, const Play& play);

 private:
  std::string fileOf(const Sweep& sweep, const Play& play) const;
  void tell(const Sweep& sweep, const Play& play) const;

  AccuracyOptions options_;
  int count_ = 0, done_ = 0;
  double left_ = 0.0, played_ = 0.0;  // costs
  double seconds_ = 0.0;              // that what was played took
};

}  // namespace tactile_clay::tools
