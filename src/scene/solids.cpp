#include "scene/solids.h"

#include <console_bridge/console.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <stdexcept>

#include "scene/joint_motions.h"
#include "scene/mesh_file.h"
#include "scene/robot_model.h"

namespace tactile_clay::scene {
namespace {

constexpr std::size_t max_solids = 1000;             // of a model: each costs time in every step
constexpr std::size_t max_model_triangles = 500000;  // of all meshes of a model: some 150 MB

Eigen::Isometry3d toEigen(const urdf::Pose& pose) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  double x, y, z, w;
  pose.rotation.getQuaternion(x, y, z, w);
  result.linear() = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
  return result;
}

/// The first error that urdfdom reports while this object exists. urdfdom reports errors on the console only,
/// and leaves parts that it cannot read out of the model.
class FirstError : public console_bridge::OutputHandler {
 public:
  FirstError() { console_bridge::useOutputHandler(this); }
  ~FirstError() override { console_bridge::restorePreviousOutputHandler(); }
  FirstError(const FirstError&) = delete;
  FirstError& operator=(const FirstError&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && text_.empty()) text_ = text;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& urdf_xml) {
  const FirstError error;
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(readyModel(urdf_xml, ""));
  if (!model || !error.text().empty())
    throw std::runtime_error("urdf: the robot model cannot be read, expected URDF XML" +
                             (error.text().empty() ? "" : ": " + error.text()));
  return model;
}

clay::Solid meshSolid(const std::string& link, const urdf::Mesh& mesh, const FindPackage& find_package) {
  clay::Solid solid;
  solid.name = link;
  solid.shape = clay::Solid::Shape::mesh;
  try {
    solid.mesh = loadMesh(pathOf(mesh.filename, "", find_package).string(),
                          {mesh.scale.x, mesh.scale.y, mesh.scale.z});
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("urdf: link '" + link + "' has a mesh as collision: " + error.what());
  }
  return solid;
}

clay::Solid toSolid(const std::string& link, const urdf::Collision& collision,
                    const FindPackage& find_package) {
  clay::Solid solid;
  solid.name = link;
  if (!collision.geometry)
    throw std::runtime_error("urdf: link '" + link + "' has a collision without geometry");
  switch (collision.geometry->type) {
    case urdf::Geometry::BOX: {
      const auto& box = dynamic_cast<const urdf::Box&>(*collision.geometry);
      solid.shape = clay::Solid::Shape::box;
      solid.size = 0.5 * Eigen::Vector3d(box.dim.x, box.dim.y, box.dim.z);
      break;
    }
    case urdf::Geometry::CYLINDER: {
      const auto& cylinder = dynamic_cast<const urdf::Cylinder&>(*collision.geometry);
      solid.shape = clay::Solid::Shape::cylinder;
      solid.size = {cylinder.radius, 0.5 * cylinder.length, 0.0};
      break;
    }
    case urdf::Geometry::SPHERE: {
      const auto& sphere = dynamic_cast<const urdf::Sphere&>(*collision.geometry);
      solid.shape = clay::Solid::Shape::sphere;
      solid.size = {sphere.radius, 0.0, 0.0};
      break;
    }
    case urdf::Geometry::MESH:
      return meshSolid(link, dynamic_cast<const urdf::Mesh&>(*collision.geometry), find_package);
    default:
      throw std::runtime_error(
          "urdf: link '" + link +
          "' has a collision of another kind, expected box, cylinder, sphere, capsule or mesh");
  }
  const int sizes = solid.shape == clay::Solid::Shape::box        ? 3
                    : solid.shape == clay::Solid::Shape::cylinder ? 2
                                                                  : 1;
  if (!(solid.size.head(sizes).minCoeff() > 0.0) || !solid.size.allFinite())
    throw std::runtime_error("urdf: link '" + link + "' has a collision without size, expected above zero");
  return solid;
}

}  // namespace

struct Solids::Model {
  urdf::ModelInterfaceSharedPtr urdf;
  JointMotions joints;
  std::vector<clay::Solid> solids;

  /// Calls f(link, collision, pose) for every collision of a link and of the links below it.
  /// @param pose of the link
  template <typename F>
  void forCollisions(const urdf::Link& link, const Eigen::Isometry3d& pose, double t, const F& f) const {
    for (const auto& collision : link.collision_array) f(link, *collision, pose * toEigen(collision->origin));
    for (const auto& joint : link.child_joints) {
      Eigen::Isometry3d next = pose * toEigen(joint->parent_to_joint_origin_transform);
      if (canMove(*joint)) {
        const double q = joints.position(joint->name, t);
        const Eigen::Vector3d axis =
            Eigen::Vector3d(joint->axis.x, joint->axis.y, joint->axis.z).normalized();
        if (joint->type == urdf::Joint::PRISMATIC)
          next.translation() += q * (next.linear() * axis);
        else if (q != 0.0)
          next.linear() = next.linear() * Eigen::AngleAxisd(q, axis).toRotationMatrix();
      }
      forCollisions(*urdf->getLink(joint->child_link_name), next, t, f);
    }
  }
  template <typename F>
  void forCollisions(double t, const F& f) const {
    forCollisions(*urdf->getRoot(), Eigen::Isometry3d::Identity(), t, f);
  }
};

Solids::Solids(const std::string& urdf_xml, const std::vector<Motion>& motions,
               const FindPackage& find_package) {
  const urdf::ModelInterfaceSharedPtr urdf = parse(urdf_xml);
  model_ = std::make_unique<Model>(Model{urdf, JointMotions(*urdf, motions), {}});
  std::size_t triangles = 0;
  model_->forCollisions(
      0.0, [&](const urdf::Link& link, const urdf::Collision& collision, const Eigen::Isometry3d& pose) {
        if (model_->solids.size() == max_solids)
          throw std::runtime_error("urdf: the links up to '" + link.name + "' have more than " +
                                   std::to_string(max_solids) + " collisions, expected fewer");
        model_->solids.push_back(toSolid(link.name, collision, find_package));
        clay::Solid& solid = model_->solids.back();
        solid.pose = pose;
        triangles += solid.mesh != nullptr ? solid.mesh->triangles() : 0;
        if (triangles > max_model_triangles)
          throw std::runtime_error("urdf: the meshes up to link '" + link.name + "' have more than " +
                                   std::to_string(max_model_triangles) + " triangles, expected fewer");
      });
}

Solids::~Solids() = default;

const std::vector<clay::Solid>& Solids::solids() const {
  return model_->solids;
}

clay::SolidMotion Solids::motion() const {
  return [model = model_.get()](double t, std::vector<Eigen::Isometry3d>& poses) {
    poses.clear();
    model->forCollisions(t, [&](const urdf::Link&, const urdf::Collision&, const Eigen::Isometry3d& pose) {
      poses.push_back(pose);
    });
  };
}

std::vector<clay::Solid> Solids::at(double t) const {
  std::vector<clay::Solid> solids = model_->solids;
  std::vector<Eigen::Isometry3d> poses;
  motion()(t, poses);
  for (std::size_t s = 0; s < solids.size(); ++s) solids[s].pose = poses[s];
  return solids;
}

std::map<std::string, double> Solids::joints(double t) const {
  std::map<std::string, double> positions;
  for (const auto& [name, joint] : model_->urdf->joints_)
    if (canMove(*joint)) positions[name] = model_->joints.position(name, t);
  return positions;
}

const std::vector<std::string>& Solids::remarks() const {
  return model_->joints.remarks();
}

}  // namespace tactile_clay::scene
