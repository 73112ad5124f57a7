#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>

#include "clay/sculpture.h"
#include "files/ends_with.h"
#include "files/input_file.h"
#include "files/output_file.h"
#include "nodes/message_check.h"
#include "nodes/share.h"
#include "nodes/surface_markers.h"
#include "nodes/topics.h"
#include "scene/scene.h"
#include "surface/clay_surface.h"
#include "surface/mesh_export.h"
#include "tools/tool_arguments.h"

namespace {

constexpr char usage[] = R"(Writes the surface of the clay as a mesh: a closed manifold, ready for a printer.

  export_mesh in:=FILE out:=FILE [scene:=kindergarten] [time:=S] [topic:=clay/particles] [overwrite:=false]

`in` is a sculpture (`save` of clay_simulator), or a bag with `clay/particles` (`record:=` of the rig). The program
takes the cloud of a bag that is `time` s after the first one; by default the last one. `out` ends in .ply (m, with
colours) or in .stl (mm). `scene` is the scene of the clay: a sculpture gets the colours of its bodies from it, a bag
gets the spacing of the particles.
)";

using namespace tactile_clay;

struct Clay {
  nodes::SurfaceParticles particles;
  double spacing;  // m
};

Clay ofSculpture(const std::string& file, const scene::Scene& scene) {
  const clay::Sculpture sculpture = clay::loadSculpture(file);
  Clay clay{{sculpture.position, {}}, sculpture.spacing};
  for (const std::uint16_t body : sculpture.body) {
    if (body >= scene.bodies.size())
      throw std::runtime_error("sculpture '" + file + "' has a body " + std::to_string(body) + ", scene '" +
                               scene.name + "' has " + std::to_string(scene.bodies.size()) +
                               ": expected scene:= with the scene of the sculpture");
    clay.particles.color.push_back(scene.bodies[body].color);
  }
  return clay;
}

Clay ofBag(const std::string& file, const std::string& topic, double time, const scene::Scene& scene) {
  files::requireInput(file, files::maximum::recording);
  rosbag::Bag bag(file);
  const auto isTopic = [&](const rosbag::ConnectionInfo* connection) {
    return connection->datatype == "sensor_msgs/PointCloud2" &&
           (connection->topic == topic || files::endsWith(connection->topic, "/" + topic));
  };
  rosbag::View view(bag, isTopic);
  if (view.size() == 0) throw std::runtime_error("bag '" + file + "' has no clouds on " + topic);
  const ros::Time from = view.begin()->getTime();
  sensor_msgs::PointCloud2::ConstPtr cloud;
  for (const rosbag::MessageInstance& instance : view) {
    if (cloud && (instance.getTime() - from).toSec() > time) break;
    cloud = instance.instantiate<sensor_msgs::PointCloud2>();
  }
  if (const std::string fault = nodes::faultOf(*cloud); !fault.empty())
    throw std::runtime_error("bag '" + file + "': " + fault);
  return {nodes::surfaceParticles(*cloud), scene.config.spacing};
}

void run(int argc, char** argv) {
  const tools::Arguments arguments(argc, argv,
                                   {{"in", ""},
                                    {"out", ""},
                                    {"scene", "kindergarten"},
                                    {"time", ""},
                                    {"topic", nodes::topic::clay_particles},
                                    {"overwrite", "false"}});
  for (const char* needed : {"in", "out"})
    if (arguments[needed].empty())
      throw std::runtime_error(std::string("expected in:=FILE out:=FILE, got no ") + needed);
  const std::string &in = arguments["in"], &out = arguments["out"];
  surface::meshFile({}, out);  // checks the name before the work begins
  const auto existing = arguments.flag("overwrite") ? files::Existing::replace : files::Existing::keep;
  const double time = arguments["time"].empty() ? std::numeric_limits<double>::infinity()
                                                : arguments.number("time", 0.0, 1e9);
  const scene::Scene scene =
      scene::loadScene(arguments["scene"], nodes::packageFolder(), 0.0, nodes::folderOfPackage);
  const Clay clay =
      files::endsWith(in, ".bag") ? ofBag(in, arguments["topic"], time, scene) : ofSculpture(in, scene);
  surface::ClaySurface surface(clay.spacing);
  const surface::TriangleMesh mesh = surface.update(clay.particles.position, clay.particles.color);
  if (mesh.triangles.empty()) throw std::runtime_error("'" + in + "' has no clay");
  files::writeWhole(out, surface::meshFile(mesh, out), existing);
  std::printf("export_mesh: %s: %zu triangles, %.1f cm^3\n", out.c_str(), mesh.triangles.size(),
              1e6 * surface::volumeOf(mesh));
}

}  // namespace

int main(int argc, char** argv) {
  return tactile_clay::tools::runTool("export_mesh", usage, argc, argv, [&] { run(argc, argv); });
}
