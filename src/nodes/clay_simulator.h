#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "clay/clay.h"
#include "nodes/clay_parameters.h"
#include "nodes/clay_run.h"
#include "nodes/clay_services.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/joint_relay.h"
#include "nodes/live_parameters.h"
#include "nodes/quality_fit.h"
#include "nodes/skin_queue.h"
#include "scene/quality.h"
#include "scene/solids.h"

namespace tactile_clay::nodes {

/// Simulates the clay of one scene: `hands/skin` in, `clay/contacts`, `clay/particles` and `clay/status` out.
///
/// Live, simulated time follows the wall clock. A new skin starts a frame at once, and a frame ends at the
/// newest skin. If no skin comes for 1.5 periods of `~rate`, a frame starts without one. Frames stay short if
/// computing is slow (`LivePace`). Time that cannot be caught up with is dropped, and this is logged. In
/// lockstep every skin makes one frame, which lasts from the stamp before to the stamp of this skin.
///
/// ClayServices save, load, replace and undo the clay.
///
/// Quality, solver, substeps, iterations, tolerance, sleeping and the coefficients of the materials may
/// change while the node runs (LiveParameters): the clay then goes on from its present state.
///
/// With `~quality` auto the node measures the speed of the computer at the start, and takes the most accurate
/// quality whose frames take at most `~target_ms`. If `~target_ms` is above 0 and frames take longer for a
/// while, it takes the next coarser quality, and logs this: it gives up accuracy before it gives up frames.
///
/// Live, and if `keep_running` would start it again, the node writes a checkpoint every
/// `~checkpoint_seconds`, from which the new node goes on.
class ClaySimulator {
 public:
  /// @throws std::runtime_error with one line if a parameter or the scene is wrong
  ClaySimulator(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ~ClaySimulator();

 private:
  using Cloud = sensor_msgs::PointCloud2;

  LiveParameters::Apply read(Settings& settings);
  void take(const scene::Quality& coarser);
  void receive(const Cloud::ConstPtr& skin);
  void runLive();
  void runLockstep();
  Skin read(const Cloud& skin);
  void publishState(ros::Time stamp);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::string node_;  // full name of this node
  bool lockstep_;
  double period_;  // s, of a live frame: 1 / `~rate`
  std::shared_ptr<ClayRun> run_;
  ClayChoice of_files_;  // parameters as the files of scene and material have them
  std::unique_ptr<scene::Solids> solids_;
  std::unique_ptr<QualityFit> fit_;
  std::atomic<unsigned> bad_skins_{0};

  SkinQueue skins_;
  Inbox inbox_;
  std::optional<JointRelay> joint_relay_;
  ros::Subscriber skin_subscriber_;
  ros::Publisher particles_, contacts_, status_, joints_;
  std::optional<ClayServices> services_;
  std::unique_ptr<Health> health_;
  std::unique_ptr<LiveParameters> live_;
  std::thread thread_;
};

}  // namespace tactile_clay::nodes
