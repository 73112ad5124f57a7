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
/// Live, simulated time follows the wall clock: a new skin starts a frame at once, the newest skin wins, and
/// where none comes the clay goes on at `~rate`. Frames stay short where computing is slow (`LivePace`); what
/// time cannot be caught up with is dropped, and said so. In lockstep every skin is one frame, of the time
/// between its stamp and the one before.
///
/// What keeps, brings back and replaces the clay are ClayServices.
///
/// Quality, substeps, iterations, tolerance, sleeping and what the materials are made of may change while it
/// runs (LiveParameters): the clay goes on from what it is.
///
/// With `~quality` auto it measures the computer at the start and takes the most accurate quality that holds
/// `~target_ms`. Where `~target_ms` is above 0 and frames take longer for a while, it takes the next coarser
/// one, and says so: accuracy is given up before frames are.
///
/// Live, where `keep_running` would start it again, it writes a checkpoint every `~checkpoint_seconds`, from
/// which it then goes on.
class ClaySimulator {
 public:
  /// @throws std::runtime_error with one line where a parameter or the scene is wrong
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

  std::string node_;  // its full name
  bool lockstep_;
  double period_;  // s, longest wait for a skin
  std::shared_ptr<ClayRun> run_;
  ClayChoice of_files_;  // as scene and materials have them
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
