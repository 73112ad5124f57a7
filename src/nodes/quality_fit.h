#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "clay/late_watch.h"
#include "scene/quality.h"
#include "scene/scene.h"
#include "scene/solids.h"

namespace tactile_clay::nodes {

/// Chooses the quality of a live clay by the measured speed of the computer, as `~quality` and `~target_ms`
/// ask.
class QualityFit {
 public:
  /// With `~quality` auto it measures the speed of the computer on the scene. The chosen quality replaces
  /// `auto` on the parameter server, so that all readers there get the quality in use.
  /// @param period s, of frames
  /// @throws std::runtime_error with one line if the speed is to decide but cannot, as in lockstep
  QualityFit(ros::NodeHandle private_nh, bool lockstep, double period, const scene::Scene& scene,
             const scene::Solids& solids);

  /// To be called after each live frame (clay::LateWatch).
  /// @param now budget with which the frame was solved
  /// @param name of the quality of the frame
  /// @return the coarser quality to go on with if frames have taken longer than `target_ms` for a while,
  /// which is logged; else null
  const scene::Quality* coarser(double elapsed, double simulated, double computing, const clay::Budget& now,
                                const std::string& name);

 private:
  std::size_t measured(const scene::Scene& scene, const scene::Solids& solids) const;

  double target_ms_;                    // 0: no limit
  std::vector<scene::Quality> steady_;  // to choose from, the coarsest first
  clay::LateWatch late_;
};

}  // namespace tactile_clay::nodes
