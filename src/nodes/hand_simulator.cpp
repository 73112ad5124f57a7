#include "nodes/hand_simulator.h"

#include <time.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_sides.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/hand_markers.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/player.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

// Processor time of this thread, s. Unlike the time of the clock it shows the cost of a frame on a busy
// machine.
double processorTime() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

HandSimulator::HandSimulator(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : world_(frameName(param<std::string>(private_nh, "world_frame", frame::world))),
      lockstep_(param(private_nh, "lockstep", false)),
      live_input_(param(private_nh, "live_input", false)),
      inbox_(private_nh),
      health_(nh, private_nh, "hand skin", [this](auto& status) { diagnose(status); }) {
  const double spacing = paramIn(private_nh, "spacing", 0.005, 0.001, 0.02);
  const auto model = param<std::string>(private_nh, "hand_model", "kinematic");
  if (model == "soft")
    soft_ = std::make_unique<hand::SoftHands>(spacing);
  else if (model == "kinematic")
    kinematic_ = std::make_unique<hand::KinematicHands>(spacing);
  else
    throw std::runtime_error("parameter " + private_nh.resolveName("hand_model") +
                             ": expected kinematic or soft, got '" + model + "'");
  const unsigned queue = lockstep_ ? 0 : 1;
  if (soft_)
    contacts_ = inbox_.subscribe<sensor_msgs::PointCloud2>(nh, topic::clay_contacts, queue,
                                                           [this](const auto& contacts) { react(contacts); });
  subscriber_ = inbox_.subscribe<TrackedHands>(
      nh, topic::hands_tracked, queue,
      [this](const auto& message, const std::string& from) { receive(message, from); });
  publisher_ = nh.advertise<sensor_msgs::PointCloud2>(topic::hands_skin, queue);
  if (soft_) bones_ = nh.advertise<visualization_msgs::MarkerArray>(topic::hands_bones, queue);
}

void HandSimulator::receive(const TrackedHands::ConstPtr& message, const std::string& publisher) {
  requireRoom(waiting_.size());
  waiting_.push_back(toCore(*message));
  waiting_.back().played = isPlayer(publisher);
  simulateWaiting();
}

void HandSimulator::react(const sensor_msgs::PointCloud2::ConstPtr& contacts) {
  try {
    bad_forces_ += soft_->react(toCore(contacts->header.stamp), contactForces(*contacts));
  } catch (const std::runtime_error& error) {
    ROS_WARN_THROTTLE(1.0, "hand_simulator: contacts left out: %s", error.what());
    ++bad_forces_;
  }
  if (awaited_ == contacts->header.stamp) awaited_.reset();
  simulateWaiting();
}

void HandSimulator::simulateWaiting() {
  while (!waiting_.empty() && !awaited_) {
    hand::TrackedFrame frame = std::move(waiting_.front());
    waiting_.pop_front();
    const ros::Time stamp = toRos(frame.stamp);
    simulate(std::move(frame));
    // Set only here: a sample that could not be simulated gets no answer.
    if (soft_ && lockstep_) awaited_ = stamp;
  }
}

void HandSimulator::simulate(hand::TrackedFrame frame) {
  // Hands are judged in world: a hand that is sane for its tracker may be too far away there.
  placeInWorld(frame, world_, transforms_);
  hand::LeftOut left_out = leaveOutBadHands(frame);
  bad_fingers_ += static_cast<unsigned>(left_out.fingers);
  bad_hands_ += static_cast<unsigned>(left_out.hands + hand::keepOneHandASide(frame.hands));
  left_out = jumps_.leaveOutJumps(frame.hands, frame.stamp);
  tell(left_out);
  bad_hands_ += static_cast<unsigned>(left_out.hands);
  if (live_input_ && !frame.played) {
    left_out = repeats_.leaveOutRepeats(frame.hands, std::chrono::steady_clock::now().time_since_epoch());
    tell(left_out);
    repeated_hands_ += static_cast<unsigned>(left_out.hands);
  }
  const auto start = ros::SteadyTime::now();
  const double processor_start = processorTime();
  const Skin skin =
      soft_ ? soft_->update(frame.hands, frame.stamp) : kinematic_->update(frame.hands, frame.stamp);
  times_.add((ros::SteadyTime::now() - start).toSec());
  processor_time_ += processorTime() - processor_start;

  std_msgs::Header header;
  header.stamp = toRos(frame.stamp);
  header.frame_id = world_;
  publisher_.publish(skinCloud(skin, header));
  for (const hand::TrackedHand& hand : frame.hands) {
    const hand::JointPose& palm = hand.joints[hand::palm];
    const Eigen::Isometry3d pose = Eigen::Translation3d(palm.position) * palm.orientation.normalized();
    const char* name = hand.side == hand::Side::left ? frame::hand_left : frame::hand_right;
    broadcaster_.send(transformMessage(world_, name, pose, header.stamp));
  }
  showBones(frame, header);
  samples_ = skin.size();
}

void HandSimulator::showBones(const hand::TrackedFrame& frame, const std_msgs::Header& header) {
  if (!soft_ || bones_.getNumSubscribers() == 0) return;
  visualization_msgs::MarkerArray markers;
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
    const auto tracked = std::find_if(frame.hands.begin(), frame.hands.end(),
                                      [side](const hand::TrackedHand& h) { return h.side == side; });
    const hand::SoftHand* soft = soft_->hand(side);
    if (tracked != frame.hands.end() && soft)
      addBones(markers, *tracked, soft->joints(), header);
    else
      removeBones(markers, side, header);
  }
  bones_.publish(markers);
}

void HandSimulator::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (repeated_hands_ > 0)
    status.summary(Level::WARN, "the tracker is frozen: it repeats its hands");
  else if (bad_hands_ > 0 || bad_fingers_ > 0)
    status.summary(Level::WARN, "hands or fingers left out");
  else if (bad_forces_ > 0)
    status.summary(Level::WARN, "forces of the clay left out");
  else
    status.summary(Level::OK, times_.frames > 0 ? "simulating" : "no frames");
  times_.report(status);
  status.add("skin samples", samples_);
  status.add("time for a frame, maximum, ms", 1e3 * times_.longest);
  status.add("processor time for a frame, mean, ms", 1e3 * times_.mean(processor_time_));
  status.add("hands left out", bad_hands_);
  status.add("fingers left out", bad_fingers_);
  status.add("hands repeated", repeated_hands_);
  if (soft_) {
    status.add("forces left out", bad_forces_);
    for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
      const hand::SoftHand* soft = soft_->hand(side);
      if (!soft) continue;
      const std::string name = side == hand::Side::left ? "left hand: " : "right hand: ";
      status.add(name + "tetrahedra", soft->tetrahedra());
      status.add(name + "tetrahedra inside out", soft->inverted());
      status.add(name + "force, N", soft->force().norm());
      int yielding = 0;
      for (int f = 0; f < hand::finger_count; ++f) yielding += soft->reach(f) < 1.0 ? 1 : 0;
      status.add(name + "fingers whose pose leaves flesh no room", yielding);
      status.add(name + "restarts", soft->restarts());
    }
  }
  inbox_.report(status);
  times_ = {};
  processor_time_ = 0.0;
  bad_hands_ = bad_fingers_ = repeated_hands_ = 0;
  bad_forces_ = 0;
}

}  // namespace tactile_clay::nodes
