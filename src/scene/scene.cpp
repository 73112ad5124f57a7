#include "scene/scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "scene/files.h"
#include "scene/mesh_file.h"
#include "scene/shape.h"
#include "scene/yaml_reader.h"
#include "values/pose.h"
#include "values/text.h"

namespace tactile_clay::scene {
namespace {

namespace fs = std::filesystem;

constexpr double max_speed = 1000.0;   // m/s, of a body at the start: more than anything thrown
constexpr double max_particles = 1e7;  // of a scene: some 5 GB, and minutes per frame

/// Where to look for the files that a scene names.
struct Places {
  fs::path beside;  // folder of the scene
  fs::path share;   // share folder of the package
  FindPackage find_package;
  std::string material;  // of all bodies; empty: their own
};

clay::Material readMaterial(YamlMap map, const std::string& name) {
  clay::Material m;
  m.name = name;
  for (const clay::Coefficient& c : clay::coefficients) {
    double& value = m.*c.value;
    if (c.value == &clay::Material::skin_friction) value = m.friction;  // if the file does not give it
    value =
        c.may_be_infinite ? map.getOrInfinite(c.name, value, c.meaning) : map.get(c.name, value, c.meaning);
  }
  map.finish();
  try {
    clay::validate(m);
  } catch (const std::invalid_argument& e) {
    map.fail(e.what());
  }
  return m;
}

/// `size` of a shape: the meaning of its numbers, as in doc/reference/scene_file.md.
struct SizeOf {
  Shape::Kind kind;
  std::size_t numbers;
  const char* meaning;
};
const std::map<std::string, SizeOf> shapes = {
    {"box", {Shape::Kind::box, 3, "three edges in m"}},
    {"cylinder", {Shape::Kind::cylinder, 3, "radius below, radius above and height in m"}},
    {"sphere", {Shape::Kind::sphere, 1, "one radius in m"}}};

Eigen::Vector3d readScale(YamlMap& map) {
  if (!map.has("scale")) return Eigen::Vector3d::Ones();
  return map.isList("scale") ? map.vector("scale", Eigen::Vector3d::Ones(), "a number, or x y z")
                             : Eigen::Vector3d::Constant(map.get("scale", 1.0, "a number, or x y z"));
}

Shape readMesh(YamlMap& map, const Places& places) {
  Shape shape;
  shape.kind = Shape::Kind::mesh;
  const std::string name = map.get<std::string>("mesh", "an STL, DAE or OBJ file");
  if (map.has("size")) map.failAt("size", "'size' of a mesh, expected 'scale': a number, or x y z");
  try {
    shape.mesh = loadMesh(pathOf(name, places.beside, places.find_package).string(), readScale(map));
  } catch (const std::runtime_error& e) {
    map.failAt("mesh", e.what());
  }
  return shape;
}

Shape readShape(YamlMap& map, const Places& places) {
  const std::string kind = map.get<std::string>("shape", "box, cylinder, sphere or mesh");
  if (kind == "mesh") return readMesh(map, places);
  const auto found = shapes.find(kind);
  if (found == shapes.end())
    map.failAt("shape", "shape '" + kind + "', expected box, cylinder, sphere or mesh");
  const SizeOf& of = found->second;
  Shape shape;
  shape.kind = of.kind;
  const std::vector<double> size = of.numbers == 1 && !map.isList("size")
                                       ? std::vector<double>{map.get<double>("size", of.meaning)}
                                       : map.numbers("size", of.numbers, of.meaning);
  for (std::size_t k = 0; k < size.size(); ++k) {
    if (!(size[k] > 0.0))
      map.failAt("size", "'size' expected numbers above zero: " + std::string(of.meaning));
    shape.size[static_cast<Eigen::Index>(k)] = size[k];
  }
  return shape;
}

Eigen::Isometry3d readPose(YamlMap& map) {
  return map.has("pose") ? values::poseOf(map.pose("pose")) : Eigen::Isometry3d::Identity();
}

/// A body's material is a named file. If the body gives a map, its values replace those of the file.
std::uint8_t materialOf(YamlMap& body, const Places& places, Scene& scene,
                        std::map<std::string, std::uint8_t>& known) {
  const auto own = body.get<std::string>("material", "the name of a material");
  const std::string& name = places.material.empty() ? own : places.material;
  const auto found = known.find(name);
  if (found != known.end()) return found->second;
  if (scene.materials.size() >= std::numeric_limits<std::uint8_t>::max())
    body.fail("more than 255 materials");
  std::string file;
  try {
    file = findFile("material", name, places.beside, places.share / "config" / "materials", ".yaml",
                    places.find_package);
  } catch (const std::runtime_error& e) {
    if (name != own) throw;
    body.failAt("material", e.what());
  }
  scene.materials.push_back(readMaterial(loadYaml(file), fs::path(file).stem().string()));
  return known[name] = static_cast<std::uint8_t>(scene.materials.size() - 1);
}

/// Whether two motions of a joint overlap in time.
bool overlap(const Motion& a, const Motion& b) {
  constexpr double rounding = 1e-9;  // s, of a start that is the sum of others
  return std::min(a.start + a.duration, b.start + b.duration) - std::max(a.start, b.start) > rounding;
}

void readBody(YamlMap map, const Places& places, Scene& scene, std::map<std::string, std::uint8_t>& known) {
  Body body;
  body.name = map.get<std::string>("name", "a name");
  body.material = materialOf(map, places, scene, known);
  body.color = map.vector("color", body.color.cast<double>(), "red, green and blue, 0-1").cast<float>();
  if (body.color.minCoeff() < 0.0f || body.color.maxCoeff() > 1.0f)
    map.fail("'color' expected numbers from 0 to 1");
  const Shape shape = readShape(map, places);
  const Eigen::Isometry3d pose = readPose(map);
  const Eigen::Vector3d velocity = map.vector("velocity", Eigen::Vector3d::Zero(), "x y z in m/s");
  if (velocity.norm() > max_speed)
    map.failAt("velocity", "'velocity' of body '" + body.name + "' is out of its range, expected at most " +
                               values::text(max_speed) + " m/s");
  map.finish();
  const double spacing = scene.config.spacing;
  if (static_cast<double>(scene.particles.size()) + cellsAround(shape, spacing) > max_particles)
    map.fail("body '" + body.name + "' makes more than " + std::to_string(static_cast<int>(max_particles)) +
             " particles, expected fewer: a smaller 'size' or a larger 'spacing'");
  const std::string out_of_world =
      "body '" + body.name + "' reaches out of the world, expected it within the half extent 'world'";
  // Nothing in the cube is longer than its diagonal. Particles lie half a spacing off the faces of a shape.
  if (extentsOf(shape).maxCoeff() > 2.0 * std::sqrt(3.0) * scene.config.world + spacing)
    map.fail(out_of_world);
  const auto points = latticeIn(shape, spacing);
  if (points.empty())
    map.fail("body '" + body.name + "' is smaller than a particle, expected at least one spacing");
  for (const Eigen::Vector3d& point : points) {
    if ((pose * point).cwiseAbs().maxCoeff() > scene.config.world) map.fail(out_of_world);
    scene.particles.push_back({(pose * point).cast<float>(), velocity.cast<float>(), body.material,
                               static_cast<std::uint16_t>(scene.bodies.size())});
  }
  scene.bodies.push_back(body);
}

}  // namespace

Scene loadScene(const std::string& name, const std::string& share, double spacing,
                const FindPackage& find_package, const std::string& material) {
  const std::string file = findFile("scene", name, "", fs::path(share) / "config" / "scenes", ".yaml");
  const Places places{fs::path(file).parent_path(), share, find_package, material};
  YamlMap map = loadYaml(file);
  Scene scene;
  scene.name = fs::path(file).stem().string();
  scene.config.spacing = map.get("spacing", scene.config.spacing, "m between particles");
  if (spacing > 0.0) scene.config.spacing = spacing;
  if (!(scene.config.spacing > 0.0 && scene.config.spacing <= 1.0))
    map.fail("'spacing' is out of its range, expected above 0 and at most 1 m");
  scene.config.gravity = map.vector("gravity", scene.config.gravity, "x y z in m/s^2");
  scene.config.world = map.get("world", scene.config.world, "m, half extent of the world");
  scene.config.tolerance =
      map.get("tolerance", scene.config.tolerance, "m/s^2, residual at which iterations stop");
  if (!(scene.config.world > 0.0)) map.fail("'world' is out of its range, expected above 0 m");
  if (!(scene.config.tolerance >= 0.0)) map.fail("'tolerance' is out of its range, expected 0 m/s^2 or more");

  const std::string urdf = map.get<std::string>("urdf", "the URDF of table and tools");
  try {
    scene.urdf =
        findFile("urdf", urdf, places.beside, places.share / "config" / "urdf", ".urdf", find_package);
  } catch (const std::runtime_error& e) {
    map.failAt("urdf", e.what());
  }

  std::map<std::string, std::uint8_t> known;
  for (const YamlMap& body : map.maps("bodies")) readBody(body, places, scene, known);
  if (scene.bodies.empty()) map.failAt("bodies", "no clay, expected at least one entry in 'bodies'");
  for (YamlMap entry : map.maps("motions")) {
    Motion motion;
    motion.joint = entry.get<std::string>("joint", "the name of a joint of the URDF");
    motion.velocity = entry.get<double>("velocity", "rad/s or m/s");
    if (!(std::abs(motion.velocity) <= max_joint_speed))
      entry.failAt("velocity", "'velocity' of a motion is out of its range, expected at most " +
                                   values::text(max_joint_speed) + " rad/s or m/s");
    motion.start = entry.get("start", 0.0, "s");
    motion.duration = entry.getOrInfinite("duration", std::numeric_limits<double>::infinity(), "s");
    entry.finish();
    if (motion.start < 0.0 || motion.duration < 0.0)
      entry.fail("'start' or 'duration' is out of its range, expected 0 s or more");
    for (const Motion& other : scene.motions)
      if (other.joint == motion.joint && overlap(other, motion))
        entry.fail("motions of joint '" + motion.joint +
                   "' overlap, expected each to end ('start' + 'duration') before the next one starts");
    scene.motions.push_back(motion);
  }
  map.finish();
  return scene;
}

clay::Material loadMaterial(const std::string& name, const std::string& share) {
  const std::string file = findFile("material", name, "", fs::path(share) / "config" / "materials", ".yaml");
  return readMaterial(loadYaml(file), fs::path(file).stem().string());
}

}  // namespace tactile_clay::scene
