#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Trigger.h>
#include <tactile_clay/SculptureFile.h>
#include <tactile_clay/Undo.h>

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "clay/clay.h"
#include "clay/keyframes.h"
#include "files/output_file.h"
#include "nodes/checkpoint.h"
#include "nodes/clay_parameters.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/joint_relay.h"
#include "nodes/live_parameters.h"
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
  void fitQuality(ros::NodeHandle private_nh);
  void goOnFromCheckpoint(const ros::NodeHandle& private_nh);
  void giveUpAccuracy();
  void receive(const Cloud::ConstPtr& skin);
  void run();
  void runLive();
  void runLockstep();
  double step(const clay::Ghosts& ghosts, double duration, double step_factor);  // s, that computing took
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

  bool lockstep_;
  double period_;  // s, longest wait for a skin
  scene::Scene scene_;
  ClayChoice of_files_;                 // as scene and materials have them
  double target_ms_ = 0.0;              // that a frame may take; 0: as long as it does
  std::vector<scene::Quality> steady_;  // among which the quality is fitted
  std::unique_ptr<scene::Solids> solids_;

  std::mutex clay_mutex_;  // guards what services replace and diagnostics read
  std::unique_ptr<clay::Clay> clay_;
  clay::Keyframes keyframes_;
  std::unique_ptr<Checkpoint> checkpoint_;                   // null where nobody would start the node again
  double checkpoint_period_ = 0.0, since_checkpoint_ = 0.0;  // s, simulated
  int changes_ = 0;                                          // of parameters that the clay was made with
  std::string quality_;                                      // that it was made with
  unsigned lowered_ = 0;                                     // times that accuracy was given up
  double simulated_ = 0.0, dropped_ = 0.0, busy_ = 0.0;      // s, since the last diagnostics
  double stepped_ = 0.0;  // s, that the steps would have simulated in their usual length
  unsigned bad_skins_ = 0, dropped_skins_ = 0;
  std::uint64_t told_rejected_ = 0;  // displacements
  std::size_t told_strays_ = 0;
  double real_time_factor_ = 1.0;
  ros::WallTime factor_since_;
  double factor_time_ = 0.0;  // s, simulated since then

  std::mutex skins_mutex_;
  std::condition_variable skin_came_;
  std::deque<Cloud::ConstPtr> skins_;
  bool stopping_ = false;

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
