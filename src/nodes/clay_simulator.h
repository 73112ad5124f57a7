#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Trigger.h>
#include <tactile_clay/SculptureFile.h>
#include <tactile_clay/Undo.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "clay/clay.h"
#include "files/output_file.h"
#include "nodes/clay_parameters.h"
#include "nodes/clay_past.h"
#include "nodes/clay_report.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/joint_relay.h"
#include "nodes/live_parameters.h"
#include "nodes/quality_fit.h"
#include "nodes/skin_queue.h"
#include "scene/quality.h"
#include "scene/scene.h"
#include "scene/solids.h"

namespace tactile_clay::nodes {

/// Simulates the clay of one scene: `hands/skin` in, `clay/contacts`, `clay/particles` and `clay/status` out.
///
/// Live, simulated time follows the wall clock: a new skin starts a frame at once, the newest skin wins, and
/// where none comes the clay goes on at `~rate`. Frames stay short where computing is slow (`LivePace`); what
/// time cannot be caught up with is dropped, and said so. In lockstep every skin is one frame, of the time
/// between its stamp and the one before.
///
/// Services: `~reset` starts the scene again, `~save` writes the clay to a new file, `~overwrite` to one that
/// may be there already, `~load` goes on from one. `~undo` goes back to a state of the last
/// `~undo_seconds` (`clay::Keyframes`), also to what was before a reset or a load.
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
  /// \throws std::runtime_error with one line where a parameter or the scene is wrong
  ClaySimulator(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ~ClaySimulator();

 private:
  using Cloud = sensor_msgs::PointCloud2;

  LiveParameters::Apply read(Settings& settings);
  void take(const scene::Quality& coarser);
  void receive(const Cloud::ConstPtr& skin);
  void runLive();
  void runLockstep();
  double step(const clay::Ghosts& ghosts, double duration, double dropped);  // s, that computing took
  clay::Ghosts read(const Cloud& skin);
  void publishContacts(const Cloud& skin, const clay::Ghosts& ghosts);
  void publishState(ros::Time stamp);
  void restart();
  bool reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool save(SculptureFile::Request& request, SculptureFile::Response& response);
  bool overwrite(SculptureFile::Request& request, SculptureFile::Response& response);
  void write(const std::string& file, files::Existing existing, SculptureFile::Response& response);
  bool load(SculptureFile::Request& request, SculptureFile::Response& response);
  bool undo(Undo::Request& request, Undo::Response& response);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::string node_;  // its full name
  bool lockstep_;
  double period_;  // s, longest wait for a skin
  scene::Scene scene_;
  ClayChoice of_files_;  // as scene and materials have them
  std::unique_ptr<scene::Solids> solids_;
  std::unique_ptr<QualityFit> fit_;

  std::mutex clay_mutex_;  // guards what services replace and diagnostics read
  std::unique_ptr<clay::Clay> clay_;
  ClayPast past_;
  ClayReport report_;
  std::string quality_;   // that the clay was made with
  unsigned lowered_ = 0;  // times that accuracy was given up
  unsigned bad_skins_ = 0;

  SkinQueue skins_;
  Inbox inbox_;
  std::optional<JointRelay> joint_relay_;
  ros::Subscriber skin_subscriber_;
  ros::Publisher particles_, contacts_, status_, joints_;
  ros::ServiceServer reset_server_, save_server_, overwrite_server_, load_server_, undo_server_;
  std::unique_ptr<Health> health_;
  std::unique_ptr<LiveParameters> live_;
  std::thread thread_;
};

}  // namespace tactile_clay::nodes
