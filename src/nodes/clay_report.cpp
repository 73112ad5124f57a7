#include "nodes/clay_report.h"

#include <ros/console.h>

namespace tactile_clay::nodes {
namespace {

// s; up to this much dropped time between two diagnostics gives no warning.
constexpr double hiccup = 0.1;

}  // namespace

void ClayReport::restart() {
  factor_since_ = ros::WallTime::now();
  factor_time_ = 0.0;
  told_rejected_ = 0;
  told_strays_ = 0;
}

void ClayReport::frame(const clay::Clay& clay, double duration, double dropped, double computing) {
  const clay::Statistics& statistics = clay.statistics();
  const std::uint64_t rejected = statistics.rejected_displacements;
  if (rejected > told_rejected_)
    ROS_WARN_THROTTLE(
        1.0,
        "clay_simulator: %llu displacements rejected since the start, not finite or longer than "
        "the world; these particles stay where they are, expected none",
        static_cast<unsigned long long>(rejected));
  told_rejected_ = rejected;
  if (statistics.strays > told_strays_)
    ROS_WARN_THROTTLE(
        10.0, "clay_simulator: %zu of %zu particles fell out of the scene and lie at the walls of the world",
        statistics.strays, clay.particles().size());
  told_strays_ = statistics.strays;
  busy_ += computing;
  dropped_ += dropped;
  simulated_ += duration;
  factor_time_ += duration;
  const ros::WallTime now = ros::WallTime::now();
  const double wall = (now - factor_since_).toSec();
  if (wall >= 1.0) {
    real_time_factor_ = factor_time_ / wall;
    factor_time_ = 0.0;
    factor_since_ = now;
  }
}

ClayStatus ClayReport::status(const clay::Clay& clay, const std_msgs::Header& header) const {
  const clay::Statistics& statistics = clay.statistics();
  ClayStatus status;
  status.header = header;
  status.step = statistics.step;
  status.particles = static_cast<std::uint32_t>(clay.particles().size());
  status.active_particles = static_cast<std::uint32_t>(statistics.awake);
  status.bonds = static_cast<std::uint32_t>(statistics.bonds);
  status.contacts = static_cast<std::uint32_t>(statistics.contacts);
  status.lumps = static_cast<std::uint32_t>(statistics.lumps);
  status.crumbs = static_cast<std::uint32_t>(statistics.crumbs);
  status.iterations = static_cast<float>(statistics.iterations);
  status.rounds = static_cast<float>(statistics.rounds);
  status.strays = static_cast<std::uint32_t>(statistics.strays);
  status.rejected_displacements = statistics.rejected_displacements;
  status.density_error_mean = static_cast<float>(statistics.density_error_mean);
  status.density_error_max = static_cast<float>(statistics.density_error_max);
  status.real_time_factor = static_cast<float>(real_time_factor_);
  for (const clay::Stage& stage : statistics.stages) {
    status.stages.push_back(stage.name);
    status.stage_ms.push_back(static_cast<float>(stage.ms));
  }
  return status;
}

bool ClayReport::diagnose(const clay::Clay& clay, diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const bool late = dropped_ > hiccup;
  if (late) {
    ROS_WARN_THROTTLE(10.0, "clay_simulator: late, %.2f s dropped; a lower quality would keep up", dropped_);
    // Clay at half its speed is another material.
    status.summary(dropped_ > simulated_ ? Level::ERROR : Level::WARN, "late: time is dropped");
  }
  status.add("particles", clay.particles().size());
  status.add("particles awake", clay.statistics().awake);
  status.add("particles out of the scene", clay.statistics().strays);
  status.add("real-time factor", real_time_factor_);
  status.add("simulated s", simulated_);
  status.add("dropped s", dropped_);
  status.add("ms of computing", 1e3 * busy_);
  simulated_ = dropped_ = busy_ = 0.0;
  return late;
}

}  // namespace tactile_clay::nodes
