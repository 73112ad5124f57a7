#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/TrackedHands.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <string>
#include <vector>

#include "nodes/display_pace.h"
#include "nodes/frame_times.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/rendered_hands.h"
#include "nodes/skin_paint.h"
#include "nodes/transforms.h"
#include "surface/capsule_surface.h"

namespace tactile_clay::nodes {

/// Shows the hands as skin: `hands/tracked`, `hands/skin` and `hands/pressure` in, `hands/surface` out:
/// markers of closed meshes on which the pressure is painted, and a colour bar in kPa beside the table. The
/// node subscribes only while somebody subscribes to its output. It publishes at most `~rate` (30) times per
/// second, less often if the computer is busy (DisplayPace), and always uses the newest messages.
///
/// Skin that touches is opaque. The rest of a hand that touches is transparent, so that contacts are seen
/// from any side. If the hand that the clay meets is not the tracked one (a soft hand), the tracked hand is
/// drawn transparent, in blue. `~full_scale` is the pressure at the end of the colour bar (40 kPa).
///
/// RenderedHands publishes `hands/rendered`.
class HandSurface {
 public:
  /// @throws std::runtime_error with one line if a parameter is wrong
  HandSurface(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  using Cloud = sensor_msgs::PointCloud2;

  void look();
  void subscribe();
  void show();
  Touch touching();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nh_;
  std::string world_;
  double full_scale_;  // kPa
  std::array<surface::CapsuleSurface, 2> surfaces_;
  TrackedHands::ConstPtr tracked_;
  Cloud::ConstPtr skin_, pressure_;
  bool news_ = false;
  FrameTimes times_;
  DisplayPace pace_;
  Transforms transforms_;

  Inbox inbox_;
  RenderedHands rendered_;
  // Exist only while somebody subscribes.
  ros::Subscriber tracked_subscriber_, skin_subscriber_, pressure_subscriber_;
  ros::Publisher publisher_;
  ros::WallTimer timer_;
  Health health_;
};

}  // namespace tactile_clay::nodes
