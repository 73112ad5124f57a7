#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/TrackedHands.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <string>
#include <vector>

#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/played_drives.h"
#include "nodes/transforms.h"
#include "surface/capsule_surface.h"
#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// Hands as skin, for the eye: `hands/tracked`, `hands/skin` and `hands/pressure` in, `hands/surface` out,
/// markers of closed meshes on which the pressure is painted, and a colour bar in kPa beside the table. While
/// nobody subscribes to it, it does not subscribe either. At most `~rate` (30) times a second; the newest
/// messages win.
///
/// Skin that touches is opaque; skin near it is a window, so that contacts are seen from any side. Where the
/// hand that the clay meets is not the tracked one (a soft hand), the tracked hand is seen through, in blue.
/// `~full_scale` is the pressure at the end of the colour bar (40 kPa).
///
/// `hands/rendered`, also only while somebody subscribes: both hands twice side by side behind the table,
/// their palms towards who looks. One has the pressure that the clay wants, the other the radiation pressure
/// that the true field of `array/drive` gives while it sounds (`array/geometry` tells where the transducers
/// are; air of
/// `~temperature`, transducers of `~reference_pressure`), each with its colour bar, and the error between
/// them.
class HandSurface {
 public:
  /// \throws std::runtime_error with one line where a parameter is wrong
  HandSurface(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  using Cloud = sensor_msgs::PointCloud2;

  /// The tracked hand of one side, and the pressure on it.
  struct Painted {
    surface::TriangleMesh mesh;
    std::vector<float> pressure;  // Pa, at each corner
  };
  /// Skin that touches.
  struct Touch {
    std::vector<Eigen::Vector3f> position, normal;  // m, unit, in world
    std::vector<float> pressure;                    // Pa
  };

  void look();
  void subscribe(bool rendered);
  void show();
  Touch touching();
  visualization_msgs::MarkerArray rendered(const std::array<Painted, 2>& hands, const Touch& touch,
                                           const std_msgs::Header& header);
  std::vector<float> given(const surface::TriangleMesh& mesh, std::vector<char>& facing);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nh_;
  std::string world_;
  double full_scale_;  // kPa
  std::array<surface::CapsuleSurface, 2> surfaces_;
  TrackedHands::ConstPtr tracked_;
  Cloud::ConstPtr skin_, pressure_;
  ultrasound::Acoustics acoustics_;
  ultrasound::ArrayLayout layout_;
  PlayedDrives played_;
  float highest_wanted_ = 0.0f, highest_given_ = 0.0f;  // Pa, of the last moments
  bool news_ = false;
  unsigned frames_ = 0;  // since the last report
  double time_ = 0.0;    // s, for them
  Transforms transforms_;

  Inbox inbox_;
  // Only while somebody looks.
  ros::Subscriber tracked_subscriber_, skin_subscriber_, pressure_subscriber_, drive_subscriber_,
      geometry_subscriber_;
  ros::Publisher publisher_, rendered_publisher_;
  ros::WallTimer timer_;
  Health health_;
};

}  // namespace tactile_clay::nodes
