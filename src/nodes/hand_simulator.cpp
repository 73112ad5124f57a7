#include "nodes/hand_simulator.h"

#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {

HandSimulator::HandSimulator(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : world_(param<std::string>(private_nh, "world_frame", frame::world)),
      hands_(paramIn(private_nh, "spacing", 0.005, 0.001, 0.02)),
      health_(nh, private_nh, "hand skin", [this](auto& status) { diagnose(status); }) {
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 1;
  subscriber_ = nh.subscribe(topic::hands_tracked, queue, &HandSimulator::receive, this,
                             ros::TransportHints().tcpNoDelay());
  publisher_ = nh.advertise<sensor_msgs::PointCloud2>(topic::hands_skin, queue);
}

void HandSimulator::receive(const TrackedHands::ConstPtr& message) {
  hand::TrackedFrame frame = toCore(*message);
  bad_hands_ += static_cast<unsigned>(leaveOutBadHands(frame));
  placeInWorld(frame, world_, transforms_);
  // Finite hands stay finite under a rigid transform, so the skin accepts what came so far.
  const hand::Skin& skin = hands_.update(frame.hands, frame.stamp);

  std_msgs::Header header;
  header.stamp = message->header.stamp;
  header.frame_id = world_;
  publisher_.publish(skinCloud(skin, header));
  for (const hand::TrackedHand& hand : frame.hands) {
    const hand::JointPose& palm = hand.joints[hand::palm];
    const Eigen::Isometry3d pose = Eigen::Translation3d(palm.position) * palm.orientation.normalized();
    const char* name = hand.side == hand::Side::left ? frame::hand_left : frame::hand_right;
    broadcaster_.sendTransform(transformMessage(world_, name, pose, header.stamp));
  }
  ++frames_;
  samples_ = skin.size();
}

void HandSimulator::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (bad_hands_ > 0)
    status.summary(Level::WARN, "hands left out");
  else
    status.summary(Level::OK, frames_ > 0 ? "simulating" : "no frames");
  status.add("frames", frames_);
  status.add("skin samples", samples_);
  status.add("hands left out", bad_hands_);
  frames_ = bad_hands_ = 0;
}

}  // namespace tactile_clay::nodes
