#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "clay/late_watch.h"
#include "scene/quality.h"
#include "scene/scene.h"
#include "scene/solids.h"

namespace tactile_clay::nodes {

/// What the computer has to say in the quality of a live clay, by `~quality` and `~target_ms`.
class QualityFit {
 public:
  /// With `~quality` auto it measures the computer on the scene. What it chooses takes the place of `auto` on
  /// the parameter server: all that look there see what holds.
  /// @param period s, of frames
  /// @throws std::runtime_error with one line where the computer is to have a say and cannot, as in lockstep
  QualityFit(ros::NodeHandle private_nh, bool lockstep, double period, const scene::Scene& scene,
             const scene::Solids& solids);

  /// To be called after each live frame (clay::LateWatch).
  /// @param now budget that it was solved with
  /// @param name of that
  /// @return the coarser quality to go on with where frames have taken longer than `target_ms` for a while,
  /// which is logged; else nothing
  const scene::Quality* coarser(double elapsed, double simulated, double computing, const clay::Budget& now,
                                const std::string& name);

 private:
  std::size_t measured(const scene::Scene& scene, const scene::Solids& solids) const;

  double target_ms_;                    // 0: frames take as long as they do
  std::vector<scene::Quality> steady_;  // among which it chooses, the coarsest first
  clay::LateWatch late_;
};

}  // namespace tactile_clay::nodes
