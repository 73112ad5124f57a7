#include "hand/hand_bodies.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "hand/anatomy.h"
#include "hand/skin_template.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int joint_sweeps = 8;
// Joints that do not move in the palm, and so determine its pose.
constexpr std::array<Joint, 9> palm_body_joints = {
    wrist,           index_metacarpal, index_proximal,    middle_metacarpal, middle_proximal,
    ring_metacarpal, ring_proximal,    little_metacarpal, little_proximal};

Vector3d rotationVector(const Quaterniond& q) {
  const Eigen::AngleAxisd turn(q.w() < 0.0 ? Quaterniond(-q.coeffs()) : q);
  return turn.angle() * turn.axis();
}

Quaterniond turned(const Quaterniond& q, const Vector3d& by) {
  const double angle = by.norm();
  if (angle < 1e-12) return q;
  return (Quaterniond(Eigen::AngleAxisd(angle, by / angle)) * q).normalized();
}

Vector3d atMost(double length, const Vector3d& v) {
  return v * std::min(1.0, length / std::max(1e-12, v.norm()));
}

// Integral of min(x, reach): the energy of a coupling of 1 N/m.
double stored(double x, double reach) {
  return x < reach ? 0.5 * x * x : reach * (x - 0.5 * reach);
}

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

// The rotation about their centres that brings `from` nearest to `to`.
template <typename Points>
Quaterniond turnOf(const Points& from, const Vector3d& from_centre, const Points& to,
                   const Vector3d& to_centre) {
  const Matrix3d covariance = (to.colwise() - to_centre) * (from.colwise() - from_centre).transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d u = svd.matrixU();
  if (u.determinant() * svd.matrixV().determinant() < 0.0) u.col(2) *= -1.0;
  return Quaterniond(Matrix3d(u * svd.matrixV().transpose()));
}

Matrix3d rotationOf(const BodyAnatomy& body, const TrackedHand& hand, const TrackedHand& rest) {
  const JointPose& frame = rest.joints[bones[body.bone].frame];
  const Vector3d along = rest.joints[body.to].position - rest.joints[body.from].position;
  return boneRotation(bones[body.bone], frame.orientation.conjugate() * along.normalized(), hand) *
         frame.orientation.toRotationMatrix().transpose();
}

}  // namespace

const std::array<BodyAnatomy, body_count> body_anatomy = {{
    {7, -1, middle_metacarpal, middle_proximal},
    {0, 0, thumb_metacarpal, thumb_proximal},
    {1, 1, thumb_proximal, thumb_distal},
    {2, 2, thumb_distal, thumb_tip},
    {4, 0, index_proximal, index_intermediate},
    {5, 4, index_intermediate, index_distal},
    {6, 5, index_distal, index_tip},
    {8, 0, middle_proximal, middle_intermediate},
    {9, 7, middle_intermediate, middle_distal},
    {10, 8, middle_distal, middle_tip},
    {12, 0, ring_proximal, ring_intermediate},
    {13, 10, ring_intermediate, ring_distal},
    {14, 11, ring_distal, ring_tip},
    {16, 0, little_proximal, little_intermediate},
    {17, 13, little_intermediate, little_distal},
    {18, 14, little_distal, little_tip},
}};

int bodyOfBone(int bone) {
  for (int b = 1; b < body_count; ++b)
    if (body_anatomy[b].bone == bone) return b;
  return palm_body;
}

std::array<Vector3d, body_count> bodyCentres(const TrackedHand& hand) {
  std::array<Vector3d, body_count> centres;
  centres[palm_body].setZero();
  for (const Joint joint : palm_body_joints)
    centres[palm_body] += hand.joints[joint].position / static_cast<double>(palm_body_joints.size());
  for (int b = 1; b < body_count; ++b)
    centres[b] =
        0.5 * (hand.joints[body_anatomy[b].from].position + hand.joints[body_anatomy[b].to].position);
  return centres;
}

BodyPose palmPose(const TrackedHand& hand, const TrackedHand& rest) {
  Eigen::Matrix<double, 3, palm_body_joints.size()> from, to;
  Eigen::Index seen = 0;
  for (const Joint joint : palm_body_joints) {
    if (hand.missing[joint]) continue;
    from.col(seen) = rest.joints[joint].position;
    to.col(seen++) = hand.joints[joint].position;
  }
  if (hand.missing.none()) {
    const Vector3d centre = to.rowwise().mean();
    return {centre, turnOf(from, Vector3d(from.rowwise().mean()), to, centre)};
  }
  const Eigen::Matrix3Xd some_from = from.leftCols(seen), some_to = to.leftCols(seen);
  const Vector3d from_centre = some_from.rowwise().mean(), to_centre = some_to.rowwise().mean();
  const Quaterniond turn = turnOf(some_from, from_centre, some_to, to_centre);
  // The centre is that of all joints, seen or not.
  const double scale = handScale(hand) / handScale(rest);
  return {to_centre + scale * (turn * (bodyCentres(rest)[palm_body] - from_centre)), turn};
}

bool palmLeaps(const BodyPose& last, const BodyPose& now) {
  constexpr double farthest = 0.5;       // m
  constexpr double farthest_turn = 2.0;  // rad
  return (now.position - last.position).norm() > farthest ||
         now.rotation.angularDistance(last.rotation) > farthest_turn;
}

BodyPoses bodyPoses(const TrackedHand& hand, const TrackedHand& rest) {
  const std::array<Vector3d, body_count> centres = bodyCentres(hand);
  BodyPoses poses;
  poses[palm_body] = palmPose(hand, rest);
  for (int b = 1; b < body_count; ++b)
    poses[b] = {centres[b], hand.missing[body_anatomy[b].to]
                                ? poses[palm_body].rotation
                                : Quaterniond(rotationOf(body_anatomy[b], hand, rest))};
  return poses;
}

HandBodies::HandBodies(const Couplings& couplings, const std::array<double, body_count>& mass,
                       const std::array<double, body_count>& gyration)
    : reach_(couplings.reach), mass_(mass), gyration_(gyration), effective_mass_(mass) {
  stiffness_.fill(couplings.finger);
  stiffness_[palm_body] = couplings.palm;
  place(BodyPoses{});
  in_body_.fill(Vector3d::Zero());
  in_parent_.fill(Vector3d::Zero());
}

void HandBodies::place(const BodyPoses& poses) {
  pose_ = before_ = poses;
  velocity_.fill(Vector3d::Zero());
  spin_.fill(Vector3d::Zero());
}

void HandBodies::joints(const TrackedHand& hand, const BodyPoses& poses) {
  for (int b = 1; b < body_count; ++b) {
    const Vector3d& at = hand.joints[body_anatomy[b].from].position;
    const BodyPose& parent = poses[body_anatomy[b].parent];
    in_body_[b] = poses[b].rotation.conjugate() * (at - poses[b].position);
    in_parent_[b] = parent.rotation.conjugate() * (at - parent.position);
  }
}

void HandBodies::predict(const BodyPoses& target, const BodyPoses& target_before, double h,
                         const std::array<double, body_count>& flesh) {
  before_ = pose_;
  for (int b = 0; b < body_count; ++b) {
    const double m = mass_[b], k = stiffness_[b], c = 2.0 * std::sqrt(k * m) + h * flesh[b];
    effective_mass_[b] = m + h * c + h * h * k;
    const Vector3d target_velocity = (target[b].position - target_before[b].position) / h;
    const Vector3d target_spin =
        rotationVector(target[b].rotation * target_before[b].rotation.conjugate()) / h;
    const Vector3d pull = atMost(reach_, target[b].position - pose_[b].position);
    const Vector3d twist =
        atMost(reach_ / gyration_[b], rotationVector(target[b].rotation * pose_[b].rotation.conjugate()));
    velocity_[b] = (m * velocity_[b] + h * k * pull + h * c * target_velocity) / effective_mass_[b];
    spin_[b] = (m * spin_[b] + h * k * twist + h * c * target_spin) / effective_mass_[b];
    pose_[b].position += h * velocity_[b];
    pose_[b].rotation = turned(pose_[b].rotation, h * spin_[b]);
  }
}

void HandBodies::push(int b, const Vector3d& impulse, const Vector3d& moment) {
  pose_[b].position += impulse / effective_mass_[b];
  pose_[b].rotation = turned(pose_[b].rotation, moment / (effective_mass_[b] * gyration_[b] * gyration_[b]));
}

void HandBodies::closeJoints() {
  for (int sweep = 0; sweep < joint_sweeps; ++sweep)
    for (int b = 1; b < body_count; ++b) {
      const int parent = body_anatomy[b].parent;
      const Vector3d r = pose_[b].rotation * in_body_[b], s = pose_[parent].rotation * in_parent_[b];
      const Vector3d gap = pose_[b].position + r - pose_[parent].position - s;
      const auto mobility = [&](int body, const Vector3d& arm) -> Matrix3d {
        const Matrix3d a = cross(arm) / gyration_[body];
        return (Matrix3d::Identity() + a * a.transpose()) / effective_mass_[body];
      };
      const Vector3d impulse = -(mobility(b, r) + mobility(parent, s)).inverse() * gap;
      push(b, impulse, r.cross(impulse));
      push(parent, -impulse, -s.cross(impulse));
    }
}

void HandBodies::finish(double h) {
  for (int b = 0; b < body_count; ++b) {
    velocity_[b] = (pose_[b].position - before_[b].position) / h;
    spin_[b] = rotationVector(pose_[b].rotation * before_[b].rotation.conjugate()) / h;
  }
}

double HandBodies::kineticEnergy() const {
  double sum = 0.0;
  for (int b = 0; b < body_count; ++b)
    sum +=
        0.5 * mass_[b] * (velocity_[b].squaredNorm() + gyration_[b] * gyration_[b] * spin_[b].squaredNorm());
  return sum;
}

double HandBodies::couplingEnergy(const BodyPoses& target) const {
  double sum = 0.0;
  for (int b = 0; b < body_count; ++b) {
    const Vector3d twist = rotationVector(target[b].rotation * pose_[b].rotation.conjugate());
    sum += stiffness_[b] * (stored((target[b].position - pose_[b].position).norm(), reach_) +
                            stored(gyration_[b] * twist.norm(), reach_));
  }
  return sum;
}

}  // namespace tactile_clay::hand
