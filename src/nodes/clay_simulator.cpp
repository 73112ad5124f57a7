#include "nodes/clay_simulator.h"

#include <sensor_msgs/JointState.h>
#include <tactile_clay/ClayStatus.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "clay/late_watch.h"
#include "clay/live_pace.h"
#include "clay/sculpture_file.h"
#include "nodes/cloud.h"
#include "nodes/conversions.h"
#include "nodes/exit_code.h"
#include "nodes/file_service.h"
#include "nodes/frame_name.h"
#include "nodes/kept.h"
#include "nodes/params.h"
#include "nodes/share.h"
#include "nodes/topics.h"
#include "scene/measured_frames.h"
#include "scene/robot_model.h"

namespace tactile_clay::nodes {
namespace {

constexpr double skin_lifetime = 0.15;     // s; a hand without news is out of the clay by then
constexpr double longer_steps = 1.05;      // mean step factor that is worth a warning
constexpr double longest_gap = 1.0;        // s; lockstep simulates at most this between two skins
constexpr std::size_t lockstep_queue = 0;  // unlimited
constexpr double usual_target =
    8.0;  // ms, of `quality:=auto`: half of a frame, the other nodes have the rest

/// How much of the past `~undo` can go back to.
clay::Keyframes::Limits undoLimits(const ros::NodeHandle& nh) {
  constexpr double megabyte = 1024.0 * 1024.0;
  clay::Keyframes::Limits limits;
  limits.seconds = paramIn(nh, "undo_seconds", limits.seconds, 0.0, 3600.0);
  const double most =
      paramIn(nh, "undo_megabytes", static_cast<double>(limits.bytes) / megabyte, 1.0, 65536.0);
  limits.bytes = static_cast<std::size_t>(megabyte * most);
  return limits;
}

}  // namespace

ClaySimulator::ClaySimulator(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : lockstep_(param(private_nh, "lockstep", false)),
      period_(1.0 / paramIn(private_nh, "rate", 60.0, 1.0, 1000.0)),
      scene_(scene::loadScene(param<std::string>(private_nh, "scene", "kindergarten"), packageFolder(), 0.0,
                              folderOfPackage, param<std::string>(private_nh, "material", ""))),
      keyframes_(undoLimits(private_nh)),
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
  fitQuality(private_nh);
  live_ = std::make_unique<LiveParameters>(nh, private_nh, [this](Settings& s) { return read(s); });
  goOnFromCheckpoint(private_nh);

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
  thread_ = std::thread([this] { run(); });
}

ClaySimulator::~ClaySimulator() {
  {
    const std::lock_guard<std::mutex> lock(skins_mutex_);
    stopping_ = true;
  }
  skin_came_.notify_all();
  thread_.join();
}

/// What it chooses takes the place of `auto` on the parameter server: all that look there see what holds.
void ClaySimulator::fitQuality(ros::NodeHandle private_nh) {
  scene::QualityWish wish;
  wish.quality = param<std::string>(private_nh, "quality", "balanced");
  wish.target_ms = paramIn(private_nh, "target_ms", 0.0, 0.0, 1000.0);
  wish.lockstep = lockstep_;
  wish.solver = param<std::string>(private_nh, "solver", "");
  wish.substeps = param(private_nh, "substeps", 0);
  wish.iterations = param(private_nh, "iterations", 0);
  const std::vector<scene::Quality> all = scene::loadQualities(packageFolder());
  scene::requireQuality(wish, all);
  if (!wish.adapts()) return;
  steady_ = scene::steadyQualities(all);
  target_ms_ = wish.target_ms > 0.0 ? wish.target_ms : usual_target;
  if (wish.quality != scene::automatic) return;
  const std::vector<double> ms = scene::measuredFrames(scene_, *solids_, steady_, target_ms_);
  const std::size_t best = scene::mostAccurate(ms, target_ms_);
  const scene::Quality& chosen = steady_[best];
  std::string measured;
  for (std::size_t k = 0; k < ms.size(); ++k) {
    char text[64];
    std::snprintf(text, sizeof text, "%s%s %.1f", k == 0 ? "" : ", ", steady_[k].name.c_str(), ms[k]);
    measured += text;
  }
  ROS_INFO("clay_simulator: quality '%s' (%d x %d) %s %g ms (measured: %s ms a frame); %s",
           chosen.name.c_str(), chosen.budget.substeps, chosen.budget.iterations,
           ms[best] <= target_ms_ ? "is the most accurate that holds" : "is the coarsest, and does not hold",
           target_ms_, measured.c_str(), scene::expectation(chosen).c_str());
  private_nh.setParam("quality", chosen.name);
  private_nh.setParam("target_ms", target_ms_);
}

/// Between two frames.
void ClaySimulator::giveUpAccuracy() {
  const scene::Quality* const coarser = scene::coarserThan(scene_.config.budget, steady_);
  if (coarser == nullptr) {
    ROS_WARN_THROTTLE(60.0, "clay_simulator: frames take longer than %g ms, and there is no coarser quality",
                      target_ms_);
    return;
  }
  live_->change({{"quality", coarser->name}, {"substeps", 0}, {"iterations", 0}});
  {
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    ++lowered_;
  }
  ROS_WARN("clay_simulator: frames took longer than %g ms for 2 s: quality '%s' instead of '%s'; %s",
           target_ms_, coarser->name.c_str(), quality_.c_str(), scene::expectation(*coarser).c_str());
}

/// A run in lockstep has none: one that lost a node is not done again to the bit.
void ClaySimulator::goOnFromCheckpoint(const ros::NodeHandle& private_nh) {
  checkpoint_period_ = paramIn(private_nh, "checkpoint_seconds", 2.0, 0.0, 3600.0);
  const std::string file = lockstep_ ? "" : keptFile(private_nh.getNamespace(), ".sculpture");
  if (file.empty() || checkpoint_period_ <= 0.0) return;
  if (isMarked(file)) {
    try {
      clay_->restore(woken(clay::loadSculpture(file)));
      ROS_WARN("clay_simulator: was started again; the clay goes on from its checkpoint at %.2f s",
               clay_->time());
    } catch (const std::exception& error) {
      ROS_ERROR("clay_simulator: was started again, and the scene with it: %s", error.what());
    }
  }
  checkpoint_ = std::make_unique<Checkpoint>(file);
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
    ++changes_;
    const clay::Sculpture sculpture = woken(clay_->sculpture());
    restart();
    clay_->restore(sculpture);
  };
}

void ClaySimulator::restart() {
  clay_ = std::make_unique<clay::Clay>(scene_.config, scene_.materials, scene_.particles);
  factor_since_ = ros::WallTime::now();
  factor_time_ = 0.0;
  told_rejected_ = 0;
  told_strays_ = 0;
}

bool ClaySimulator::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  keyframes_.keep(clay_->sculpture(), changes_);
  restart();
  since_checkpoint_ = checkpoint_period_;  // what is gone does not come back
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
    keyframes_.keep(before, changes_);
    since_checkpoint_ = checkpoint_period_;
    return "scene '" + scene_.name + "' goes on from " + request.file;
  });
  return true;
}

bool ClaySimulator::undo(Undo::Request& request, Undo::Response& response) {
  answer(response, [&] {
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    const clay::Keyframes::State& state = keyframes_.back(request.seconds, response.went_back);
    // What sleeps may not hold any more with other parameters.
    clay_->restore(state.version == changes_ ? state.clay : woken(state.clay));
    since_checkpoint_ = checkpoint_period_;
    char text[80];
    std::snprintf(text, sizeof text, "the clay is what it was %.2f s ago, at %.2f s", response.went_back,
                  clay_->time());
    return std::string(text);
  });
  return true;
}

void ClaySimulator::receive(const Cloud::ConstPtr& skin) {
  if (frameName(skin->header.frame_id) != frame::world) {
    ROS_WARN_THROTTLE(1.0, "clay_simulator: skin in frame '%s' left out, expected '%s'",
                      skin->header.frame_id.c_str(), frame::world);
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(skins_mutex_);
    if (!lockstep_ && !skins_.empty()) {
      skins_.clear();
      ++dropped_skins_;
    }
    requireRoom(skins_.size());
    skins_.push_back(skin);
  }
  skin_came_.notify_all();
}

void ClaySimulator::run() {
  try {
    lockstep_ ? runLockstep() : runLive();
  } catch (const std::exception& error) {
    ROS_FATAL("clay_simulator: %s", error.what());
    finish(1);
  }
}

clay::Ghosts ClaySimulator::read(const Cloud& skin) {
  try {
    const std::size_t most = clay::mostGhosts(scene_.config.spacing), count = pointCount(skin);
    if (count > most)
      throw std::runtime_error(std::to_string(count) + " samples, expected at most " + std::to_string(most) +
                               " at a spacing of " + std::to_string(scene_.config.spacing) + " m");
    return ghosts(skin);
  } catch (const std::runtime_error& error) {
    ROS_WARN_THROTTLE(1.0, "clay_simulator: skin left out: %s", error.what());
    const std::lock_guard<std::mutex> lock(clay_mutex_);
    ++bad_skins_;
    return {};
  }
}

double ClaySimulator::step(const clay::Ghosts& ghosts, double duration, double step_factor) {
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  const ros::WallTime start = ros::WallTime::now();
  if (keyframes_.pass(0.0)) keyframes_.keep(clay_->sculpture(), changes_);  // the start
  clay_->advance(ghosts, solids_->solids(), solids_->motion(), duration, step_factor);
  if (keyframes_.pass(duration)) keyframes_.keep(clay_->sculpture(), changes_);
  since_checkpoint_ += duration;
  if (checkpoint_ && since_checkpoint_ >= checkpoint_period_) {
    checkpoint_->keep(clay_->sculpture());
    since_checkpoint_ = 0.0;
  }
  const std::uint64_t rejected = clay_->statistics().rejected_displacements;
  if (rejected > told_rejected_)
    ROS_WARN_THROTTLE(
        1.0,
        "clay_simulator: %llu displacements rejected since the start, not finite or longer than "
        "the world; these particles stay where they are, expected none",
        static_cast<unsigned long long>(rejected));
  told_rejected_ = rejected;
  if (clay_->statistics().strays > told_strays_)
    ROS_WARN_THROTTLE(
        10.0, "clay_simulator: %zu of %zu particles fell out of the scene and lie at the walls of the world",
        clay_->statistics().strays, clay_->particles().size());
  told_strays_ = clay_->statistics().strays;
  const ros::WallTime now = ros::WallTime::now();
  const double computing = (now - start).toSec();
  busy_ += computing;
  simulated_ += duration;
  stepped_ += duration / step_factor;
  factor_time_ += duration;
  const double wall = (now - factor_since_).toSec();
  if (wall >= 1.0) {
    real_time_factor_ = factor_time_ / wall;
    factor_time_ = 0.0;
    factor_since_ = now;
  }
  return computing;
}

void ClaySimulator::runLockstep() {
  ros::Time before;
  while (true) {
    Cloud::ConstPtr skin;
    {
      std::unique_lock<std::mutex> lock(skins_mutex_);
      skin_came_.wait(lock, [this] { return stopping_ || !skins_.empty(); });
      if (stopping_) return;
      skin = skins_.front();
      skins_.pop_front();
    }
    const ros::Time stamp = skin->header.stamp;
    double duration = before.isZero() ? scene_.config.frame : secondsBetween(before, stamp);
    if (duration < 0.0 || duration > longest_gap)
      ROS_WARN_THROTTLE(1.0, "clay_simulator: %.3f s between two skins, expected 0 to %.0f s", duration,
                        longest_gap);
    duration = std::clamp(duration, 0.0, longest_gap);
    before = stamp;
    live_->begin(stamp);
    const clay::Ghosts ghosts = read(*skin);
    step(ghosts, duration, 1.0);
    publishState(stamp);
    publishContacts(*skin, ghosts);  // last: the answer from the array means that all was published
  }
}

void ClaySimulator::runLive() {
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> period(period_);
  Clock::time_point before = Clock::now(), skin_at = before - std::chrono::hours(1);
  clay::Ghosts held;
  double step_length = scene_.config.timeStep();
  clay::LivePace pace(period_, step_length);
  clay::LateWatch late(1e-3 * target_ms_, period_);
  while (true) {
    Cloud::ConstPtr skin;
    {
      std::unique_lock<std::mutex> lock(skins_mutex_);
      // Skins at the tracker's rate start the frames; half a period of grace keeps the two clocks from
      // beating.
      const auto next = before + std::chrono::duration_cast<Clock::duration>(1.5 * period);
      skin_came_.wait_until(lock, next, [this] { return stopping_ || !skins_.empty(); });
      if (stopping_) return;
      if (!skins_.empty()) {
        skin = skins_.front();
        skins_.pop_front();
      }
    }
    beat();  // where frames are long, services wait
    const Clock::time_point now = Clock::now();
    live_->begin(skin ? skin->header.stamp : ros::Time::now());
    if (scene_.config.timeStep() != step_length)
      pace = clay::LivePace(period_, step_length = scene_.config.timeStep());
    const double elapsed = std::chrono::duration<double>(now - before).count();
    const clay::LiveFrame frame = pace.next(elapsed);
    before = now;
    {
      const std::lock_guard<std::mutex> lock(clay_mutex_);
      dropped_ += pace.takeDropped();
    }
    if (skin) {
      held = read(*skin);
      skin_at = now;
    } else {
      if (std::chrono::duration<double>(now - skin_at).count() > skin_lifetime) held = {};
      std::fill(held.velocity.begin(), held.velocity.end(), Eigen::Vector3f::Zero());
    }
    const double computing = step(held, frame.duration, frame.step_factor);
    pace.took(computing);
    if (target_ms_ > 0.0 && late.late(elapsed, frame.duration / frame.step_factor, computing))
      giveUpAccuracy();
    if (skin) publishContacts(*skin, held);
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
  if (!joints.empty()) {
    auto message = boost::make_shared<sensor_msgs::JointState>();
    message->header = header;
    // Joints are for robot_state_publisher: it complains of states as old as a recording, and makes
    // transforms that go back of states that do.
    message->header.stamp = ros::Time::now();
    for (const auto& [name, position] : joints) {
      message->name.push_back(name);
      message->position.push_back(position);
    }
    joints_.publish(message);
  }

  const clay::Statistics& statistics = clay_->statistics();
  auto status = boost::make_shared<ClayStatus>();
  status->header = header;
  status->step = statistics.step;
  status->particles = static_cast<std::uint32_t>(clay_->particles().size());
  status->active_particles = static_cast<std::uint32_t>(statistics.awake);
  status->bonds = static_cast<std::uint32_t>(statistics.bonds);
  status->contacts = static_cast<std::uint32_t>(statistics.contacts);
  status->lumps = static_cast<std::uint32_t>(statistics.lumps);
  status->crumbs = static_cast<std::uint32_t>(statistics.crumbs);
  status->iterations = static_cast<float>(statistics.iterations);
  status->rounds = static_cast<float>(statistics.rounds);
  status->strays = static_cast<std::uint32_t>(statistics.strays);
  status->rejected_displacements = statistics.rejected_displacements;
  status->density_error_mean = static_cast<float>(statistics.density_error_mean);
  status->density_error_max = static_cast<float>(statistics.density_error_max);
  status->real_time_factor = static_cast<float>(real_time_factor_);
  status->step_factor = static_cast<float>(statistics.step_factor);
  status->quality = quality_;
  status->lowered = lowered_;
  for (const clay::Stage& stage : statistics.stages) {
    status->stages.push_back(stage.name);
    status->stage_ms.push_back(static_cast<float>(stage.ms));
  }
  status_.publish(status);
}

void ClaySimulator::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  unsigned dropped_skins = 0;
  {
    const std::lock_guard<std::mutex> lock(skins_mutex_);
    dropped_skins = dropped_skins_;
  }
  const std::lock_guard<std::mutex> lock(clay_mutex_);
  if (dropped_ > 0.1) {
    ROS_WARN_THROTTLE(10.0, "clay_simulator: late, %.2f s dropped; a lower quality would keep up", dropped_);
    // Clay at half its speed is another material.
    status.summary(dropped_ > simulated_ ? Level::ERROR : Level::WARN, "late: time is dropped");
  } else if (bad_skins_ > 0) {
    status.summary(Level::WARN, "skins left out");
  } else if (simulated_ > longer_steps * stepped_) {
    ROS_WARN_THROTTLE(
        10.0,
        "clay_simulator: frames take too long; to be on time, steps are %.2f times as long, which "
        "costs accuracy. A lower quality would keep up",
        simulated_ / stepped_);
    status.summary(Level::WARN, "on time by longer steps, which costs accuracy");
  } else if (lowered_ > 0) {
    status.summary(Level::OK, "simulating, at the lower quality '" + quality_ + "' to be on time");
  } else {
    status.summary(Level::OK, "simulating");
  }
  status.add("scene", scene_.name);
  status.add("particles", clay_->particles().size());
  status.add("particles awake", clay_->statistics().awake);
  status.add("particles out of the scene", clay_->statistics().strays);
  status.add("real-time factor", real_time_factor_);
  status.add("quality", quality_);
  status.add("quality lowered, times", lowered_);
  status.add("simulated s", simulated_);
  status.add("dropped s", dropped_);
  status.add("step factor", stepped_ > 0.0 ? simulated_ / stepped_ : 1.0);
  status.add("ms of computing", 1e3 * busy_);
  status.add("skins left out", bad_skins_);
  status.add("undo, states", keyframes_.size());
  status.add("undo, MB", 1e-6 * static_cast<double>(keyframes_.bytes()));
  status.add("skins overtaken by newer ones", dropped_skins);
  inbox_.report(status);
  simulated_ = stepped_ = dropped_ = busy_ = 0.0;
}

}  // namespace tactile_clay::nodes
