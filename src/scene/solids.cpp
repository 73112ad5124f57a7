#include "scene/solids.h"

#include <console_bridge/console.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <stdexcept>

namespace tactile_clay::scene {
namespace {

Eigen::Isometry3d toEigen(const urdf::Pose& pose) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  double x, y, z, w;
  pose.rotation.getQuaternion(x, y, z, w);
  result.linear() = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
  return result;
}

/// The first error that urdfdom tells while this lives. It tells them on the console only, and leaves out of
/// a model what it could not read.
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
  urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(urdf_xml);
  if (!model || !error.text().empty())
    throw std::runtime_error("urdf: the robot model cannot be read, expected URDF XML" +
                             (error.text().empty() ? "" : ": " + error.text()));
  return model;
}

clay::Solid toSolid(const std::string& link, const urdf::Collision& collision) {
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
    default:
      throw std::runtime_error("urdf: link '" + link +
                               "' has a mesh as collision, expected box, cylinder or sphere");
  }
  const int sizes = solid.shape == clay::Solid::Shape::box        ? 3
                    : solid.shape == clay::Solid::Shape::cylinder ? 2
                                                                  : 1;
  if (!(solid.size.head(sizes).minCoeff() > 0.0))
    throw std::runtime_error("urdf: link '" + link + "' has a collision without size, expected above zero");
  return solid;
}

struct Twist {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // m/s of the origin
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // rad/s
};

}  // namespace

struct Solids::Model {
  urdf::ModelInterfaceSharedPtr urdf;
  std::vector<Motion> motions;

  double position(const Motion& m, double t) const {
    return m.velocity * std::clamp(t - m.start, 0.0, std::max(m.duration, 0.0));
  }
  double velocity(const Motion& m, double t) const {
    return t >= m.start && t < m.start + m.duration ? m.velocity : 0.0;
  }
  const Motion* motionOf(const std::string& joint) const {
    const auto found =
        std::find_if(motions.begin(), motions.end(), [&](const Motion& m) { return m.joint == joint; });
    return found == motions.end() ? nullptr : &*found;
  }

  void collect(const urdf::Link& link, const Twist& twist, double t, std::vector<clay::Solid>& solids) const {
    for (const auto& collision : link.collision_array) {
      clay::Solid solid = toSolid(link.name, *collision);
      solid.pose = twist.pose * toEigen(collision->origin);
      solid.angular_velocity = twist.angular;
      solid.linear_velocity =
          twist.linear + twist.angular.cross(solid.pose.translation() - twist.pose.translation());
      solids.push_back(solid);
    }
    for (const auto& joint : link.child_joints) {
      const auto child = urdf->getLink(joint->child_link_name);
      Twist next;
      next.pose = twist.pose * toEigen(joint->parent_to_joint_origin_transform);
      next.angular = twist.angular;
      next.linear = twist.linear + twist.angular.cross(next.pose.translation() - twist.pose.translation());
      const Eigen::Vector3d axis = Eigen::Vector3d(joint->axis.x, joint->axis.y, joint->axis.z).normalized();
      if (const Motion* motion = motionOf(joint->name)) {
        const double q = position(*motion, t), rate = velocity(*motion, t);
        const Eigen::Vector3d world_axis = next.pose.linear() * axis;
        if (joint->type == urdf::Joint::PRISMATIC) {
          next.pose.translation() += q * world_axis;
          next.linear += rate * world_axis;
        } else {
          next.pose.linear() = next.pose.linear() * Eigen::AngleAxisd(q, axis).toRotationMatrix();
          next.angular += rate * world_axis;
        }
      }
      collect(*child, next, t, solids);
    }
  }
};

Solids::Solids(const std::string& urdf_xml, const std::vector<Motion>& motions)
    : model_(std::make_unique<Model>()) {
  model_->urdf = parse(urdf_xml);
  model_->motions = motions;
  for (const Motion& motion : motions) {
    const auto joint = model_->urdf->getJoint(motion.joint);
    if (!joint)
      throw std::runtime_error("scene: motion of joint '" + motion.joint + "', expected a joint of the URDF");
    if (joint->type != urdf::Joint::CONTINUOUS && joint->type != urdf::Joint::REVOLUTE &&
        joint->type != urdf::Joint::PRISMATIC) {
      throw std::runtime_error("scene: joint '" + motion.joint +
                               "' cannot move, expected a continuous, revolute or prismatic joint");
    }
    if (joint->axis.x == 0.0 && joint->axis.y == 0.0 && joint->axis.z == 0.0)
      throw std::runtime_error("urdf: joint '" + motion.joint +
                               "' has no axis, expected one that is not zero");
  }
  at(0.0);  // every collision shape is looked at once, so that a bad one is found here
}

Solids::~Solids() = default;

std::vector<clay::Solid> Solids::at(double t) const {
  std::vector<clay::Solid> solids;
  model_->collect(*model_->urdf->getRoot(), Twist{}, t, solids);
  return solids;
}

std::map<std::string, double> Solids::joints(double t) const {
  std::map<std::string, double> positions;
  for (const auto& entry : model_->urdf->joints_) {
    const urdf::Joint& joint = *entry.second;
    if (joint.type == urdf::Joint::FIXED || joint.type == urdf::Joint::UNKNOWN) continue;
    const Motion* motion = model_->motionOf(entry.first);
    positions[entry.first] = motion != nullptr ? model_->position(*motion, t) : 0.0;
  }
  return positions;
}

}  // namespace tactile_clay::scene
