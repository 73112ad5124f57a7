#include "nodes/clay_run.h"

#include <boost/make_shared.hpp>
#include <utility>

#include "nodes/conversions.h"

namespace tactile_clay::nodes {
namespace {

using Lock = std::lock_guard<std::mutex>;

}  // namespace

ClayRun::ClayRun(const ros::NodeHandle& private_nh, scene::Scene scene, bool lockstep)
    : scene_(std::move(scene)), past_(private_nh, lockstep) {}

void ClayRun::change(const ClayChoice& choice) {
  const Lock lock(mutex_);
  scene_.config = choice.config;
  scene_.materials = choice.materials;
  quality_ = choice.quality;
  if (!clay_) return restart();
  // The clay goes on from its present state, as from a saved sculpture. It is woken, because sleeping clay
  // may not be in equilibrium with other parameters.
  past_.parametersChanged();
  const clay::Sculpture sculpture = woken(clay_->sculpture());
  restart();
  clay_->restore(sculpture);
}

void ClayRun::restart() {
  clay_ = std::make_unique<clay::Clay>(scene_.config, scene_.materials, scene_.particles);
  report_.restart();
}

void ClayRun::goOn() {
  const Lock lock(mutex_);
  past_.goOn(*clay_);
}

void ClayRun::lower() {
  const Lock lock(mutex_);
  ++lowered_;
}

double ClayRun::step(const Skin& samples, const scene::Solids& solids, double duration, double dropped) {
  const Lock lock(mutex_);
  const ros::WallTime start = ros::WallTime::now();
  past_.before(*clay_);
  clay_->advance(samples, solids.solids(), solids.motion(), duration);
  past_.after(*clay_, duration);
  const double computing = (ros::WallTime::now() - start).toSec();
  report_.frame(*clay_, duration, dropped, computing);
  return computing;
}

sensor_msgs::PointCloud2Ptr ClayRun::contacts(const Skin& samples,
                                              const sensor_msgs::PointCloud2& skin) const {
  const Lock lock(mutex_);
  // After a reset between `step` and here there are no forces, as it should be.
  return contactCloud(clay_->skinForces(), samples, skin);
}

ClayRun::State ClayRun::state(const std_msgs::Header& header, bool with_particles) const {
  const Lock lock(mutex_);
  State state{clay_->time(), with_particles ? particleCloud(*clay_, scene_, header) : nullptr,
              boost::make_shared<ClayStatus>(report_.status(*clay_, header))};
  state.status->quality = quality_;
  state.status->lowered = lowered_;
  return state;
}

void ClayRun::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const Lock lock(mutex_);
  if (!report_.diagnose(*clay_, status))
    status.summary(Level::OK, lowered_ == 0
                                  ? "simulating"
                                  : "simulating, at the lower quality '" + quality_ + "' to be on time");
  status.add("scene", scene_.name);
  status.add("quality", quality_);
  status.add("quality lowered, times", lowered_);
  status.add("undo, states", past_.states().size());
  status.add("undo, MB", 1e-6 * static_cast<double>(past_.states().bytes()));
}

void ClayRun::reset() {
  const Lock lock(mutex_);
  past_.keep(clay_->sculpture());
  restart();
}

clay::Sculpture ClayRun::sculpture() const {
  const Lock lock(mutex_);
  return clay_->sculpture();
}

void ClayRun::restore(const clay::Sculpture& sculpture) {
  const Lock lock(mutex_);
  const clay::Sculpture before = clay_->sculpture();
  clay_->restore(sculpture);
  past_.keep(before);
}

ClayRun::Undone ClayRun::undo(double seconds) {
  const Lock lock(mutex_);
  const double went_back = past_.undo(seconds, *clay_);
  return {went_back, clay_->time()};
}

}  // namespace tactile_clay::nodes
