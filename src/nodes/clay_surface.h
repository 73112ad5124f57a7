#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/SculptureFile.h>

#include "files/output_file.h"
#include "nodes/display_pace.h"
#include "nodes/frame_times.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "surface/clay_surface.h"

namespace tactile_clay::nodes {

/// The surface of the clay, for display: `clay/particles` in, `clay/surface` out, a marker of triangles. The
/// node subscribes only while somebody subscribes to its output. It publishes at most `~rate` (30) times per
/// second, less often if the computer is busy (DisplayPace), and always uses the newest particles.
///
/// `~scene` is the scene of clay_simulator; its spacing of the particles is used. The services `~export` and
/// `~overwrite` write the surface as PLY or STL, depending on the ending of the file name. Only `~overwrite`
/// replaces a file.
class ClaySurface {
 public:
  /// @throws std::runtime_error with one line if a parameter or the scene is wrong
  ClaySurface(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  using Cloud = sensor_msgs::PointCloud2;

  void look();
  void show(const Cloud& cloud);
  void write(const std::string& file, files::Existing existing, SculptureFile::Response& response);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nh_;
  surface::ClaySurface surface_;
  Cloud::ConstPtr latest_;  // newest particles, not shown yet
  FrameTimes times_;
  DisplayPace pace_;
  std::size_t triangles_ = 0;

  Inbox inbox_;
  ros::Subscriber subscriber_;  // exists only while somebody subscribes
  ros::Publisher publisher_;
  ros::ServiceServer export_server_, overwrite_server_;
  ros::WallTimer timer_;
  Health health_;
};

}  // namespace tactile_clay::nodes
