#include "nodes/clay_surface.h"

#include <visualization_msgs/Marker.h>

#include <stdexcept>

#include "nodes/file_service.h"
#include "nodes/params.h"
#include "nodes/share.h"
#include "nodes/surface_markers.h"
#include "nodes/topics.h"
#include "scene/scene.h"
#include "surface/mesh_export.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

const ros::Duration export_patience(5.0);  // s, in which the clay has to publish particles

double spacingOf(const ros::NodeHandle& nh) {
  return scene::loadScene(param<std::string>(nh, "scene", "kindergarten"), packageFolder(), 0.0,
                          folderOfPackage)
      .config.spacing;
}

}  // namespace

ClaySurface::ClaySurface(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : nh_(nh),
      surface_(spacingOf(private_nh)),
      inbox_(private_nh),
      health_(nh, private_nh, "clay surface", [this](auto& status) { diagnose(status); }) {
  publisher_ = nh.advertise<visualization_msgs::Marker>(topic::clay_surface, 1);
  const auto serve = [this](files::Existing existing) {
    return [this, existing](SculptureFile::Request& request, SculptureFile::Response& response) {
      write(request.file, existing, response);
      return true;
    };
  };
  using Serve = boost::function<bool(SculptureFile::Request&, SculptureFile::Response&)>;
  export_server_ = private_nh.advertiseService("export", Serve(serve(files::Existing::keep)));
  overwrite_server_ = private_nh.advertiseService("overwrite", Serve(serve(files::Existing::replace)));
  timer_ = nh.createWallTimer(ros::WallDuration(1.0 / paramIn(private_nh, "rate", 30.0, 1.0, 240.0)),
                              [this](const ros::WallTimerEvent&) { look(); });
}

void ClaySurface::look() {
  const bool watched = publisher_.getNumSubscribers() > 0;
  if (!watched) {
    subscriber_.shutdown();
    latest_.reset();
  } else if (!subscriber_) {
    subscriber_ = inbox_.subscribe<Cloud>(nh_, topic::clay_particles, 1,
                                          [this](const auto& cloud) { latest_ = cloud; });
  }
  if (!latest_ || !pace_.isDue(ros::SteadyTime::now())) return;
  const Cloud::ConstPtr cloud = std::move(latest_);
  latest_.reset();
  try {
    show(*cloud);
  } catch (const std::exception& error) {
    ROS_WARN_THROTTLE(5.0, "clay_surface: particles left out: %s",
                      values::printableLine(error.what()).c_str());
  }
}

void ClaySurface::show(const Cloud& cloud) {
  const auto start = ros::SteadyTime::now();
  const SurfaceParticles particles = surfaceParticles(cloud);
  const surface::TriangleMesh mesh = surface_.update(particles.position, particles.color);
  publisher_.publish(surfaceMarker(mesh, lit(mesh), mesh.triangles, 1.0f, cloud.header, "clay", 0));
  triangles_ = mesh.triangles.size();
  const auto end = ros::SteadyTime::now();
  times_.add((end - start).toSec());
  pace_.worked(start, end);
}

void ClaySurface::write(const std::string& file, files::Existing existing,
                        SculptureFile::Response& response) {
  answer(response, [&] {
    requireAbsolute("mesh", file);
    surface::meshFile({}, file);  // checks the ending of the name before the wait
    const Cloud::ConstPtr cloud =
        ros::topic::waitForMessage<Cloud>(topic::clay_particles, nh_, export_patience);
    if (!cloud)
      throw std::runtime_error("mesh '" + file +
                               "': no clay/particles within 5 s, expected a running clay_simulator");
    if (const std::string fault = faultOf(*cloud); !fault.empty()) throw std::runtime_error(fault);
    const SurfaceParticles particles = surfaceParticles(*cloud);
    const surface::TriangleMesh mesh = surface_.update(particles.position, particles.color);
    files::writeWhole(file, surface::meshFile(mesh, file), existing);
    return std::to_string(mesh.triangles.size()) + " triangles written to " + file;
  });
}

void ClaySurface::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  status.summary(Level::OK, subscriber_ ? times_.frames > 0 ? "showing" : "no particles" : "no subscriber");
  times_.report(status);
  status.add("triangles", triangles_);
  times_ = {};
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
