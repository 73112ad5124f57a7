#include "nodes/clay_simulator.h"

#include <sensor_msgs/JointState.h>
#include <tactile_clay/ClayStatus.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "clay/live_pace.h"
#include "clay/sculpture_file.h"
#include "clay/skin_path.h"
#include "nodes/cloud.h"
#include "nodes/conversions.h"
#include "nodes/exit_code.h"
#include "nodes/file_service.h"
#include "nodes/frame_name.h"
#include "nodes/kept.h"
#include "nodes/params.h"
#include "nodes/share.h"
#include "nodes/topics.h"
#include "scene/robot_model.h"

namespace tactile_clay::nodes {
namespace {

constexpr double skin_lifetime = 0.15;     // s; a hand without news is out of the clay by then
constexpr double longest_gap = 1.0;        // s; lockstep simulates at most this between two skins
constexpr std::size_t lockstep_queue = 0;  // unlimited

}  // namespace

ClaySimulator::ClaySimulator(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : node_(private_nh.getNamespace()),
      lockstep_(param(private_nh, "lockstep", false)),
      period_(1.0 / paramIn(private_nh, "rate", 60.0, 1.0, 1000.0)),
      scene_(scene::loadScene(param<std::string>(private_nh, "scene", "kindergarten"), packageFolder(), 0.0,
                              folderOfPackage, param<std::string>(private_nh, "material", ""))),
      past_(private_nh, lockstep_),
      skins_(lockstep_),
      inbox_(private_nh) {
  scene_.config.threads = paramIn(private_nh, "threads", 0, 0, 1024);
  of_files_ = {scene_.config, "", scene_.materials};
  // The clay collides with what the rest of the graph knows as the robot.
  std::string urdf, source = "parameter " + nh.resolveName("robot_description");
  if (!nh.getParam("robot_description", urdf)) urdf = scene::loadRobotModel(source = scene_.urdf);
  try {
    solids_ = std::make_unique<scene::Solids>(urdf, scene_.motions, folderOfPackage);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(source + ": " + error.what());
  }
  for (const std::string& remark : solids_->remarks()) ROS_WARN("clay_simulator: %s", remark.c_str());
  fit_ = std::make_unique<QualityFit>(private_nh, lockstep_, period_, scene_, *solids_);
  live_ = std::make_unique<LiveParameters>(nh, private_nh, [this](Settings& s) { return read(s); });
  past_.goOn(*clay_);

  skin_subscriber_ = inbox_.subscribe<Cloud>(nh, topic::hands_skin, lockstep_ ? lockstep_queue : 1,
                                             [this](const auto& skin) { receive(skin); });
  reset_server_ = private_nh.advertiseService("reset", &ClaySimulator::reset, this);
  save_server_ = private_nh.advertiseService("save", &ClaySimulator::save, this);
  overwrite_server_ = private_nh.advertiseService("overwrite", &ClaySimulator::overwrite, this);
  load_server_ = private_nh.advertiseService("load", &ClaySimulator::load, this);
  undo_server_ = private_nh.advertiseService("undo", &ClaySimulator::undo, this);
  const unsigned queue = lockstep_ ? lockstep_queue : 2;
  particles_ = nh.advertise<Cloud>(topic::clay_particles, queue);
  status_ = nh.advertise<ClayStatus>(topic::clay_status, queue);
  joints_ = nh.advertise<sensor_msgs::JointState>(topic::joint_states, queue);
  contacts_ = nh.advertise<Cloud>(topic::clay_contacts, queue);
  joint_relay_.emplace(nh, inbox_, topic::joint_states);
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

/// Between two frames.
void ClaySimulator::take(const scene::Quality& coarser) {
  live_->change({{"quality", coarser.name}, {"substeps", 0}, {"iterations", 0}});
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  ++lowered_;
}

LiveParameters::Apply ClaySimulator::read(Settings& settings) {
  ClayChoice choice = readClay(settings, of_files_.config, of_files_.materials);
  return [this, choice = std::move(choice)] {
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    scene_.config = choice.config;
    scene_.materials = choice.materials;
    quality_ = choice.quality;
    if (!clay_) return restart();
    // The clay goes on from what it is, as from a sculpture that was saved; what sleeps may not hold any
    // more.
    past_.parametersChanged();
    const clay::Sculpture sculpture = woken(clay_->sculpture());
    restart();
    clay_->restore(sculpture);
  };
}

void ClaySimulator::restart() {
  clay_ = std::make_unique<clay::Clay>(scene_.config, scene_.materials, scene_.particles);
  report_.restart();
}

bool ClaySimulator::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  past_.keep(clay_->sculpture());
  restart();
  response.success = true;
  response.message = "scene '" + scene_.name + "' starts again";
  return true;
}

bool ClaySimulator::save(SculptureFile::Request& request, SculptureFile::Response& response) {
  write(request.file, files::Existing::keep, response);
  return true;
}

bool ClaySimulator::overwrite(SculptureFile::Request& request, SculptureFile::Response& response) {
  write(request.file, files::Existing::replace, response);
  return true;
}

void ClaySimulator::write(const std::string& file, files::Existing existing,
                          SculptureFile::Response& response) {
  clay::Sculpture sculpture;
  {
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    sculpture = clay_->sculpture();
  }
  answer(response, [&] {
    requireAbsolute("sculpture", file);
    clay::save(sculpture, file, existing);
    return "scene '" + scene_.name + "' saved in " + file;
  });
}

bool ClaySimulator::load(SculptureFile::Request& request, SculptureFile::Response& response) {
  answer(response, [&] {
    requireAbsolute("sculpture", request.file);
    const clay::Sculpture sculpture = clay::loadSculpture(request.file);
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    const clay::Sculpture before = clay_->sculpture();
    clay_->restore(sculpture);
    past_.keep(before);
    return "scene '" + scene_.name + "' goes on from " + request.file;
  });
  return true;
}

bool ClaySimulator::undo(Undo::Request& request, Undo::Response& response) {
  answer(response, [&] {
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    response.went_back = past_.undo(request.seconds, *clay_);
    char text[80];
    std::snprintf(text, sizeof text, "the clay is what it was %.2f s ago, at %.2f s", response.went_back,
                  clay_->time());
    return std::string(text);
  });
  return true;
}

void ClaySimulator::receive(const Cloud::ConstPtr& skin) {
  if (frameName(skin->header.frame_id) == frame::world) return skins_.push(skin);
  ROS_WARN_THROTTLE(1.0, "clay_simulator: skin in frame '%s' left out, expected '%s'",
                    skin->header.frame_id.c_str(), frame::world);
}

clay::Ghosts ClaySimulator::read(const Cloud& skin) {
  try {
    return ghosts(skin, clay::mostGhosts(scene_.config.spacing));
  } catch (const std::runtime_error& error) {
    ROS_WARN_THROTTLE(1.0, "clay_simulator: skin left out: %s", error.what());
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    ++bad_skins_;
    return {};
  }
}

double ClaySimulator::step(const clay::Ghosts& ghosts, double duration, double dropped) {
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  const ros::WallTime start = ros::WallTime::now();
  past_.before(*clay_);
  clay_->advance(ghosts, solids_->solids(), solids_->motion(), duration);
  past_.after(*clay_, duration);
  const double computing = (ros::WallTime::now() - start).toSec();
  report_.frame(*clay_, duration, dropped, computing);
  return computing;
}

void ClaySimulator::runLockstep() {
  ros::Time before;
  for (std::vector<Cloud::ConstPtr> skins; skins_.wait({}, skins);) {
    const Cloud::ConstPtr& skin = skins.front();
    const ros::Time stamp = skin->header.stamp;
    double duration = before.isZero() ? scene_.config.frame : secondsBetween(before, stamp);
    if (duration < 0.0 || duration > longest_gap)
      ROS_WARN_THROTTLE(1.0, "clay_simulator: %.3f s between two skins, expected 0 to %.0f s", duration,
                        longest_gap);
    duration = std::clamp(duration, 0.0, longest_gap);
    before = stamp;
    live_->begin(stamp);
    const clay::Ghosts ghosts = read(*skin);
    step(ghosts, duration, 0.0);
    publishState(stamp);
    publishContacts(*skin, ghosts);  // last: the answer from the array means that all was published
  }
}

void ClaySimulator::runLive() {
  using Clock = SkinQueue::Clock;
  Clock::time_point before = Clock::now(), skin_at = before - std::chrono::hours(1);
  clay::SkinPath path;
  double step_length = scene_.config.timeStep();
  clay::LivePace pace(period_, step_length);
  // Skins at the tracker's rate start the frames; half a period of grace keeps the two clocks from beating.
  const auto patience =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.5 * period_));
  for (std::vector<Cloud::ConstPtr> skins; skins_.wait(before + patience, skins);) {
    beat(node_);  // where frames are long, services wait
    const Cloud::ConstPtr skin = skins.empty() ? nullptr : skins.back();
    const Clock::time_point now = Clock::now();
    live_->begin(skin ? skin->header.stamp : ros::Time::now());
    if (scene_.config.timeStep() != step_length)
      pace = clay::LivePace(period_, step_length = scene_.config.timeStep());
    const double elapsed = std::chrono::duration<double>(now - before).count();
    const double duration = pace.next(elapsed);
    before = now;
    for (const Cloud::ConstPtr& came : skins) path.add(read(*came), came->header.stamp.toSec());
    if (skin)
      skin_at = now;
    else if (std::chrono::duration<double>(now - skin_at).count() > skin_lifetime)
      path = {};
    const clay::Ghosts ghosts = path.frame(duration);
    const double computing = step(ghosts, duration, pace.takeDropped());
    pace.took(duration, computing);
    if (const scene::Quality* const coarser =
            fit_->coarser(elapsed, duration, computing, scene_.config.budget, quality_))
      take(*coarser);
    if (skin) publishContacts(*skin, ghosts);
    publishState(skin ? skin->header.stamp : ros::Time::now());
  }
}

void ClaySimulator::publishContacts(const Cloud& skin, const clay::Ghosts& ghosts) {
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  // A reset between the step and here leaves no forces, which is right.
  contacts_.publish(contactCloud(clay_->ghostForces(), ghosts, skin));
}

void ClaySimulator::publishState(ros::Time stamp) {
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = frame::world;
  if (particles_.getNumSubscribers() > 0) particles_.publish(particleCloud(*clay_, scene_, header));

  const auto joints = solids_->joints(clay_->time());
  // Joints are for robot_state_publisher: it complains of states as old as a recording, and makes transforms
  // that go back of states that do.
  if (!joints.empty()) joints_.publish(jointState(joints, ros::Time::now()));

  auto status = boost::make_shared<ClayStatus>(report_.status(*clay_, header));
  status->quality = quality_;
  status->lowered = lowered_;
  status_.publish(status);
}

void ClaySimulator::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  const bool late = report_.diagnose(*clay_, status);
  if (!late && bad_skins_ > 0)
    status.summary(Level::WARN, "skins left out");
  else if (!late && lowered_ > 0)
    status.summary(Level::OK, "simulating, at the lower quality '" + quality_ + "' to be on time");
  else if (!late)
    status.summary(Level::OK, "simulating");
  status.add("scene", scene_.name);
  status.add("quality", quality_);
  status.add("quality lowered, times", lowered_);
  status.add("skins left out", bad_skins_);
  status.add("undo, states", past_.states().size());
  status.add("undo, MB", 1e-6 * static_cast<double>(past_.states().bytes()));
  status.add("skins overtaken by newer ones", skins_.overtaken());
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
