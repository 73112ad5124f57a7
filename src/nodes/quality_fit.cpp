#include "nodes/quality_fit.h"

#include <ros/console.h>

#include <cstdio>
#include <string>

#include "nodes/params.h"
#include "nodes/share.h"
#include "scene/measured_frames.h"

namespace tactile_clay::nodes {
namespace {

constexpr double usual_target = 8.0;  // ms, default of `auto`: half of a frame; the other nodes get the rest

scene::QualityWish wishOf(const ros::NodeHandle& nh, bool lockstep) {
  scene::QualityWish wish;
  wish.quality = param<std::string>(nh, "quality", "balanced");
  wish.target_ms = paramIn(nh, "target_ms", 0.0, 0.0, 1000.0);
  wish.lockstep = lockstep;
  wish.solver = param<std::string>(nh, "solver", "");
  wish.substeps = param(nh, "substeps", 0);
  wish.iterations = param(nh, "iterations", 0);
  return wish;
}

double targetOf(const scene::QualityWish& wish) {
  if (!wish.adapts()) return 0.0;
  return wish.target_ms > 0.0 ? wish.target_ms : usual_target;
}

}  // namespace

QualityFit::QualityFit(ros::NodeHandle private_nh, bool lockstep, double period, const scene::Scene& scene,
                       const scene::Solids& solids)
    : target_ms_(targetOf(wishOf(private_nh, lockstep))), late_(1e-3 * target_ms_, period) {
  const scene::QualityWish wish = wishOf(private_nh, lockstep);
  const std::vector<scene::Quality> all = scene::loadQualities(packageFolder());
  scene::requireQuality(wish, all);
  if (!wish.adapts()) return;
  steady_ = scene::steadyQualities(all);
  if (wish.quality != scene::automatic) return;
  private_nh.setParam("quality", steady_[measured(scene, solids)].name);
  private_nh.setParam("target_ms", target_ms_);
}

/// @return index of the quality to take
std::size_t QualityFit::measured(const scene::Scene& scene, const scene::Solids& solids) const {
  const std::vector<double> ms = scene::measuredFrames(scene, solids, steady_, target_ms_);
  const std::size_t best = scene::mostAccurate(ms, target_ms_);
  const scene::Quality& chosen = steady_[best];
  std::string each;
  for (std::size_t k = 0; k < ms.size(); ++k) {
    char text[64];
    std::snprintf(text, sizeof text, "%s%s %.1f", k == 0 ? "" : ", ", steady_[k].name.c_str(), ms[k]);
    each += text;
  }
  const std::string budget =
      std::to_string(chosen.budget.substeps) + " x " + std::to_string(chosen.budget.iterations);
  ROS_INFO("clay_simulator: quality '%s' (%s) %s %g ms (measured: %s ms a frame); %s", chosen.name.c_str(),
           budget.c_str(),
           ms[best] <= target_ms_ ? "is the most accurate that holds" : "is the coarsest, and does not hold",
           target_ms_, each.c_str(), scene::expectation(chosen).c_str());
  return best;
}

const scene::Quality* QualityFit::coarser(double elapsed, double simulated, double computing,
                                          const clay::Budget& now, const std::string& name) {
  if (target_ms_ <= 0.0 || !late_.late(elapsed, simulated, computing)) return nullptr;
  const scene::Quality* const next = scene::coarserThan(now, steady_);
  if (next != nullptr)
    ROS_WARN("clay_simulator: frames took longer than %g ms for 2 s: quality '%s' instead of '%s'; %s",
             target_ms_, next->name.c_str(), name.c_str(), scene::expectation(*next).c_str());
  else
    ROS_WARN_THROTTLE(60.0, "clay_simulator: frames take longer than %g ms, and there is no coarser quality",
                      target_ms_);
  return next;
}

}  // namespace tactile_clay::nodes
