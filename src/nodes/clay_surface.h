#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/SculptureFile.h>

#include "files/output_file.h"
#include "nodes/frame_times.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "surface/clay_surface.h"

namespace tactile_clay::nodes {

/// The surface of the clay, for the eye: `clay/particles` in, `clay/surface` out, a marker of triangles.
/// While nobody subscribes to it, it does not subscribe either. At most `~rate` (30) times a second; the
/// newest particles win.
///
/// `~scene` is that of clay_simulator: it tells the spacing of the particles. Services `~export` and
/// `~overwrite` write the surface as PLY or STL, by the end of the file's name; only the second one replaces
/// a file.
class ClaySurface {
 public:
  /// @throws std::runtime_error with one line where a parameter or the scene is wrong
  ClaySurface(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  using Cloud = sensor_msgs::PointCloud2;

  void look();
  void show(const Cloud& cloud);
  void write(const std::string& file, files::Existing existing, SculptureFile::Response& response);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nh_;
  surface::ClaySurface surface_;
  Cloud::ConstPtr latest_;  // not shown yet
  FrameTimes times_;
  std::size_t triangles_ = 0;

  Inbox inbox_;
  ros::Subscriber subscriber_;  // only while somebody looks
  ros::Publisher publisher_;
  ros::ServiceServer export_server_, overwrite_server_;
  ros::WallTimer timer_;
  Health health_;
};

}  // namespace tactile_clay::nodes
