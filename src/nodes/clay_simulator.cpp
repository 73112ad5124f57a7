#include "nodes/clay_simulator.h"

#include <sensor_msgs/JointState.h>
#include <tactile_clay/ClayStatus.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <stdexcept>
#include <utility>

#include "clay/live_pace.h"
#include "clay/skin_path.h"
#include "nodes/conversions.h"
#include "nodes/exit_code.h"
#include "nodes/frame_name.h"
#include "nodes/kept.h"
#include "nodes/params.h"
#include "nodes/share.h"
#include "nodes/topics.h"
#include "scene/overlap.h"
#include "scene/robot_model.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

// s; if no skin came for this long, the hand no longer acts on the clay.
constexpr double skin_lifetime = 0.15;
constexpr double longest_gap = 1.0;        // s; lockstep simulates at most this between two skins
constexpr std::size_t lockstep_queue = 0;  // unlimited

scene::Scene sceneOf(const ros::NodeHandle& private_nh) {
  scene::Scene scene =
      scene::loadScene(param<std::string>(private_nh, "scene", "kindergarten"), packageFolder(), 0.0,
                       folderOfPackage, param<std::string>(private_nh, "material", ""));
  scene.config.threads = paramIn(private_nh, "threads", 0, 0, 1024);
  return scene;
}

/// The clay collides with the robot of the parameter `robot_description`, as the rest of the graph knows it.
/// If there is none, with the robot of the scene.
std::unique_ptr<scene::Solids> solidsOf(const ros::NodeHandle& nh, const scene::Scene& scene) {
  std::string urdf, source = "parameter " + nh.resolveName("robot_description");
  if (!nh.getParam("robot_description", urdf)) urdf = scene::loadRobotModel(source = scene.urdf);
  std::unique_ptr<scene::Solids> solids;
  try {
    solids = std::make_unique<scene::Solids>(urdf, scene.motions, folderOfPackage);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(source + ": " + error.what());
  }
  for (const std::string& remark : solids->remarks()) ROS_WARN("clay_simulator: %s", remark.c_str());
  for (const std::string& line : scene::startsInside(scene, solids->solids()))
    ROS_WARN("clay_simulator: %s", values::printableLine(line).c_str());
  return solids;
}

}  // namespace

ClaySimulator::ClaySimulator(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : node_(private_nh.getNamespace()),
      lockstep_(param(private_nh, "lockstep", false)),
      period_(1.0 / paramIn(private_nh, "rate", 60.0, 1.0, 1000.0)),
      run_(std::make_shared<ClayRun>(private_nh, sceneOf(private_nh), lockstep_)),
      of_files_{run_->scene().config, "", run_->scene().materials},
      solids_(solidsOf(nh, run_->scene())),
      skins_(lockstep_),
      inbox_(private_nh) {
  fit_ = std::make_unique<QualityFit>(private_nh, lockstep_, period_, run_->scene(), *solids_);
  live_ = std::make_unique<LiveParameters>(nh, private_nh, [this](Settings& s) { return read(s); });
  run_->goOn();

  skin_subscriber_ = inbox_.subscribe<Cloud>(nh, topic::hands_skin, lockstep_ ? lockstep_queue : 1,
                                             [this](const auto& skin) { receive(skin); });
  services_.emplace(private_nh, run_);
  const unsigned queue = lockstep_ ? lockstep_queue : 2;
  particles_ = nh.advertise<Cloud>(topic::clay_particles, queue);
  status_ = nh.advertise<ClayStatus>(topic::clay_status, queue);
  joints_ = nh.advertise<sensor_msgs::JointState>(topic::joint_states, queue);
  contacts_ = nh.advertise<Cloud>(topic::clay_contacts, queue);
  std::set<std::string> movable;
  for (const auto& [name, position] : solids_->joints(0.0)) movable.insert(name);
  joint_relay_.emplace(nh, inbox_, topic::joint_states, movable);
  health_ = std::make_unique<Health>(nh, private_nh, "clay", [this](auto& status) { diagnose(status); });
  thread_ = std::thread([this] {
    try {
      lockstep_ ? runLockstep() : runLive();
    } catch (const std::exception& error) {
      ROS_FATAL("clay_simulator: %s", error.what());
      finish(1);
    }
  });
}

ClaySimulator::~ClaySimulator() {
  skins_.stop();
  thread_.join();
}

/// Called between two frames.
void ClaySimulator::take(const scene::Quality& coarser) {
  live_->change({{"quality", coarser.name}, {"substeps", 0}, {"iterations", 0}});
  run_->lower();
}

LiveParameters::Apply ClaySimulator::read(Settings& settings) {
  ClayChoice choice = readClay(settings, of_files_.config, of_files_.materials);
  return [this, choice = std::move(choice)] { run_->change(choice); };
}

void ClaySimulator::receive(const Cloud::ConstPtr& skin) {
  if (frameName(skin->header.frame_id) == frame::world) return skins_.push(skin);
  ROS_WARN_THROTTLE(1.0, "clay_simulator: skin in frame '%s' left out, expected '%s'",
                    values::printableLine(skin->header.frame_id).c_str(), frame::world);
}

Skin ClaySimulator::read(const Cloud& skin) {
  try {
    return claySkin(skin, clay::maxSkinSamples(run_->scene().config.spacing));
  } catch (const std::runtime_error& error) {
    ROS_WARN_THROTTLE(1.0, "clay_simulator: skin left out: %s", error.what());
    ++bad_skins_;
    return {};
  }
}

void ClaySimulator::runLockstep() {
  ros::Time before;
  for (std::vector<Cloud::ConstPtr> skins; skins_.wait({}, skins);) {
    const Cloud::ConstPtr& skin = skins.front();
    const ros::Time stamp = skin->header.stamp;
    double duration = before.isZero() ? run_->scene().config.frame : secondsBetween(before, stamp);
    if (duration < 0.0 || duration > longest_gap)
      ROS_WARN_THROTTLE(1.0, "clay_simulator: %.3f s between two skins, expected 0 to %.0f s", duration,
                        longest_gap);
    duration = std::clamp(duration, 0.0, longest_gap);
    before = stamp;
    live_->begin(stamp);
    const Skin samples = read(*skin);
    run_->step(samples, *solids_, duration, 0.0);
    publishState(stamp);
    // Published last: when the array answers, all other messages of this frame are published, too.
    contacts_.publish(run_->contacts(samples, *skin));
  }
}

void ClaySimulator::runLive() {
  using Clock = SkinQueue::Clock;
  Clock::time_point before = Clock::now(), skin_at = before - std::chrono::hours(1);
  clay::SkinPath path;
  double step_length = run_->scene().config.timeStep();
  clay::LivePace pace(period_, step_length);
  // Skins that come at the tracker's rate start the frames. The wait for a skin is half a period longer than
  // a frame, so that the two clocks do not beat against each other.
  const auto patience =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.5 * period_));
  for (std::vector<Cloud::ConstPtr> skins; skins_.wait(before + patience, skins);) {
    // A sign of life from here, too: during long frames a service call blocks the thread of the callbacks.
    beat(node_);
    const Cloud::ConstPtr skin = skins.empty() ? nullptr : skins.back();
    const Clock::time_point now = Clock::now();
    live_->begin(skin ? skin->header.stamp : ros::Time::now());
    if (run_->scene().config.timeStep() != step_length)
      pace = clay::LivePace(period_, step_length = run_->scene().config.timeStep());
    const double elapsed = std::chrono::duration<double>(now - before).count();
    const double duration = pace.next(elapsed);
    before = now;
    for (const Cloud::ConstPtr& came : skins) path.add(read(*came), came->header.stamp.toSec());
    if (skin)
      skin_at = now;
    else if (std::chrono::duration<double>(now - skin_at).count() > skin_lifetime)
      path = {};
    const Skin samples = path.frame(duration);
    const double computing = run_->step(samples, *solids_, duration, pace.takeDropped());
    pace.took(duration, computing);
    if (const scene::Quality* const coarser =
            fit_->coarser(elapsed, duration, computing, run_->scene().config.budget, run_->quality()))
      take(*coarser);
    if (skin) contacts_.publish(run_->contacts(samples, *skin));
    publishState(skin ? skin->header.stamp : ros::Time::now());
  }
}

void ClaySimulator::publishState(ros::Time stamp) {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = frame::world;
  const ClayRun::State state = run_->state(header, particles_.getNumSubscribers() > 0);
  if (state.particles) particles_.publish(state.particles);

  const auto joints = solids_->joints(state.time);
  // Joints get the present time, because they are for robot_state_publisher: it warns of states that are as
  // old as a recording, and if their stamps go back, so do its transforms.
  if (!joints.empty()) joints_.publish(jointState(joints, ros::Time::now()));
  status_.publish(state.status);
}

void ClaySimulator::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  run_->diagnose(status);
  if (status.level == Level::OK && bad_skins_ > 0) status.summary(Level::WARN, "skins left out");
  status.add("skins left out", bad_skins_.load());
  status.add("skins overtaken by newer ones", skins_.overtaken());
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
