#include "hand/soft_hand.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "hand/anatomy.h"
#include "hand/reach.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double longest_frame = 0.1;  // s, the most that is simulated for one tracker sample
constexpr double resize_from = 0.01;   // relative change of the person's size

std::array<double, body_count> gyrations(const TrackedHand& rest) {
  std::array<double, body_count> g;
  g[palm_body] = 0.04;
  for (int b = 1; b < body_count; ++b)
    g[b] =
        0.5 * (rest.joints[body_anatomy[b].to].position - rest.joints[body_anatomy[b].from].position).norm();
  return g;
}

// Bones and flesh of each body, kg.
std::array<double, body_count> masses(const TrackedHand& rest, double density) {
  std::array<double, body_count> m;
  m[palm_body] = 0.25;  // the palm, without the part of the arm that moves with it
  for (int b = 1; b < body_count; ++b) {
    const JointPose &from = rest.joints[body_anatomy[b].from], &to = rest.joints[body_anatomy[b].to];
    const double r = 0.5 * (from.radius + to.radius);
    m[b] = density * M_PI * r * r * (to.position - from.position).norm();
  }
  return m;
}

BodyPose between(const BodyPose& a, const BodyPose& b, double t) {
  return {a.position + t * (b.position - a.position), a.rotation.slerp(t, b.rotation)};
}

}  // namespace

SoftHand::SoftHand(std::shared_ptr<const SoftHandTemplate> anatomy, const Skin& skin, double skin_scale,
                   const SoftHandParameters& parameters)
    : anatomy_(std::move(anatomy)),
      parameters_(parameters),
      centre_(bodyCentres(anatomy_->rest)),
      flesh_(anatomy_->mesh, Elasticity::of(parameters.young, parameters.poisson)),
      bodies_(parameters.couplings, masses(anatomy_->rest, parameters.density), gyrations(anatomy_->rest)),
      skin_(*anatomy_, skin, skin_scale),
      loads_(skin_.points()) {
  const std::size_t count = anatomy_->mesh.nodes.size();
  nodes_.assign(count + unused_flesh_nodes, FleshNode::Zero());
  std::array<double, body_count> square{};
  for (std::size_t n = 0; n < count; ++n) {
    const NodeBinding& binding = anatomy_->bindings[n];
    nodes_[n].head<3>() = anatomy_->mesh.nodes[n].cast<float>();
    if (!binding.rigid) continue;
    rigid_.push_back(static_cast<int>(n));
    ++rigid_nodes_[binding.body];
    square[binding.body] += (anatomy_->mesh.nodes[n] - centre_[binding.body]).squaredNorm();
  }
  // So light that all nodes together turn and move no harder than the body. Collecting them then only damps.
  for (int b = 0; b < body_count; ++b) {
    const double g = bodies_.gyration(b);
    node_share_[b] = std::min(1.0 / rigid_nodes_[b], g * g / square[b]);
  }
  in_body_.resize(rigid_.size());
  resize(skin_scale);
}

void SoftHand::resize(double scale) {
  scale_ = scale;
  flesh_.rest(scale);
  const std::vector<double> stiffness = flesh_.stiffness();
  for (std::size_t n = 0; n < stiffness.size(); ++n)
    if (stiffness[n] > 0.0) nodes_[n][3] = static_cast<float>(1.0 / (parameters_.relaxation * stiffness[n]));
  flesh_stiffness_.fill(0.0);
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int n = rigid_[i], b = anatomy_->bindings[n].body;
    in_body_[i] = scale * (anatomy_->mesh.nodes[n] - centre_[b]);
    // A node of bone then gives way as a node of flesh does, on average.
    flesh_stiffness_[b] += parameters_.relaxation * stiffness[n] / (node_share_[b] * rigid_nodes_[b]);
  }
}

Vector3d SoftHand::skinned(int n, const BodyPoses& poses) const {
  const NodeBinding& binding = anatomy_->bindings[n];
  const auto by = [&](int b) -> Vector3d {
    return poses[b].position + poses[b].rotation * (scale_ * (anatomy_->mesh.nodes[n] - centre_[b]));
  };
  const double share = binding.other_share;
  return (1.0 - share) * by(binding.body) + share * by(binding.other);
}

void SoftHand::place(const TrackedHand& tracked) {
  yields_.fill({});
  const TrackedHand hand = withinReach(tracked);
  resize(handScale(hand));
  target_ = bodyPoses(hand, anatomy_->rest);
  bodies_.place(target_);
  for (std::size_t n = 0; n < anatomy_->bindings.size(); ++n)
    nodes_[n].head<3>() = skinned(static_cast<int>(n), target_).cast<float>();
  inverted_.clear();
  rememberPoints();
  loads_.reset();
}

void SoftHand::advance(const TrackedHand& tracked, double dt) {
  const TrackedHand hand = withinReach(tracked, yields_);
  const double scale = handScale(hand);
  if (std::abs(scale / scale_ - 1.0) > resize_from) resize(scale);
  const BodyPoses from = target_, to = bodyPoses(hand, anatomy_->rest);
  bodies_.joints(hand, to);
  const double duration = std::min(dt, longest_frame);
  const int steps = std::max(1, static_cast<int>(std::ceil(duration / parameters_.step)));
  BodyPoses before = from;
  for (int k = 1; k <= steps; ++k) {
    BodyPoses target;
    for (int b = 0; b < body_count; ++b) target[b] = between(from[b], to[b], static_cast<double>(k) / steps);
    step(target, before, duration / steps);
    before = target;
  }
  target_ = to;
  yield(yields_, tracked, palmPose(tracked, anatomy_->rest), duration);
  if (!sane()) {
    place(tracked);
    ++restarts_;
  }
}

bool SoftHand::leaps(const TrackedHand& tracked) const {
  return palmLeaps(target_[palm_body], palmPose(tracked, anatomy_->rest));
}

bool SoftHand::sane() const {
  for (std::size_t n = 0; n < anatomy_->bindings.size(); ++n)
    if (!((nodes_[n].head<3>().cast<double>() - target_[palm_body].position).norm() < 1.0)) return false;
  return true;
}

void SoftHand::step(const BodyPoses& target, const BodyPoses& before, double h) {
  const BodyPoses start = bodies_.poses();
  bodies_.predict(target, before, h, flesh_stiffness_);
  carryFlesh(start);
  carryBones();
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int b = anatomy_->bindings[rigid_[i]].body;
    nodes_[rigid_[i]][3] = static_cast<float>(h * h / (bodies_.mass(b) * node_share_[b]));
  }
  loads_.apply(nodes_);
  flesh_.project(nodes_, squeezed_);
  loads_.project(nodes_);
  rememberPoints();
  const BodyPoses predicted = bodies_.poses();
  collect(h);
  bodies_.closeJoints();
  bodies_.finish(h);
  carryFlesh(predicted);
  carryBones();
  const auto home = [this](int n) -> Vector3f { return skinned(n, bodies_.poses()).cast<float>(); };
  addStep(yields_, inverted_.step(flesh_, anatomy_->bindings, home, loads_.pressed(), nodes_), h);
}

// Moves flesh with its bones, which have moved since `from`.
void SoftHand::carryFlesh(const BodyPoses& from) {
  std::array<Eigen::Matrix3f, body_count> turn;
  std::array<Vector3f, body_count> shift;
  for (int b = 0; b < body_count; ++b) {
    const BodyPose &before = from[b], &now = bodies_.poses()[b];
    const Eigen::Matrix3d r = (now.rotation * before.rotation.conjugate()).toRotationMatrix();
    turn[b] = (r - Eigen::Matrix3d::Identity()).cast<float>();
    shift[b] =
        (now.position - before.position - (r - Eigen::Matrix3d::Identity()) * before.position).cast<float>();
  }
  for (std::size_t n = 0; n < anatomy_->bindings.size(); ++n) {
    const NodeBinding& binding = anatomy_->bindings[n];
    if (binding.rigid) continue;
    const Vector3f x = nodes_[n].head<3>();
    const int a = binding.body, b = binding.other;
    const float share = binding.other_share;
    nodes_[n].head<3>() += (1.0F - share) * (turn[a] * x + shift[a]) + share * (turn[b] * x + shift[b]);
  }
}

void SoftHand::carryBones() {
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const BodyPose& pose = bodies_.poses()[anatomy_->bindings[rigid_[i]].body];
    nodes_[rigid_[i]].head<3>() = (pose.position + pose.rotation * in_body_[i]).cast<float>();
  }
}

// Applies to each body what flesh and loads did to its nodes of bone. In the pass over the flesh each of
// these nodes gives way by itself, more than the whole bone does. So flesh that the clay squeezes against the
// bone gets its minimum volume here, where the bone really is.
void SoftHand::collect(double h) {
  std::array<Vector3d, body_count> impulse, moment;
  impulse.fill(Vector3d::Zero());
  moment.fill(Vector3d::Zero());
  std::vector<Vector3d> each(rigid_.size());  // kg m
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int b = anatomy_->bindings[rigid_[i]].body;
    FleshNode& node = nodes_[rigid_[i]];
    const Vector3d at = bodies_.poses()[b].position + bodies_.poses()[b].rotation * in_body_[i];
    each[i] = bodies_.mass(b) * node_share_[b] * (node.head<3>().cast<double>() - at);
    node << at.cast<float>(), 0.0F;
  }
  if (inverted_.caught() || (!loads_.empty() && !squeezed_.empty())) {
    reaction_.assign(nodes_.size(), Vector3f::Zero());
    flesh_.limit(squeezed_, nodes_, reaction_);
    // Flesh passes on what presses it. Volume that it lacks for another reason, as in a leap, throws no bone.
    std::array<Vector3d, body_count> sum;
    sum.fill(Vector3d::Zero());
    for (const int n : rigid_) sum[anatomy_->bindings[n].body] += reaction_[n].cast<double>();
    double strongest = 1e-12;
    for (const Vector3d& force : sum) strongest = std::max(strongest, force.norm());
    const double share = std::min(1.0, 2.0 * loads_.strength() / strongest);
    for (std::size_t i = 0; i < rigid_.size(); ++i)
      each[i] += share * h * h * reaction_[rigid_[i]].cast<double>();
  }
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int b = anatomy_->bindings[rigid_[i]].body;
    impulse[b] += each[i];
    moment[b] += (bodies_.poses()[b].rotation * in_body_[i]).cross(each[i]);
  }
  for (int b = 0; b < body_count; ++b) bodies_.push(b, impulse[b], moment[b]);
}

void SoftHand::rememberPoints() {
  points_.clear();
  for (const FleshPoint& point : skin_.points()) points_.push_back(point.position(nodes_));
}

void SoftHand::appendTo(Skin& skin) const {
  skin_.appendTo(skin, *anatomy_, nodes_, static_cast<float>(scale_));
}

std::array<Vector3d, joint_count> SoftHand::joints() const {
  const auto by = [this](int b, int joint) -> Vector3d {
    const BodyPose& pose = bodies_.poses()[b];
    return pose.position + pose.rotation * (scale_ * (anatomy_->rest.joints[joint].position - centre_[b]));
  };
  std::array<Vector3d, joint_count> positions;
  for (int joint = 0; joint < joint_count; ++joint) positions[joint] = by(palm_body, joint);
  for (int b = 1; b < body_count; ++b) positions[body_anatomy[b].to] = by(b, body_anatomy[b].to);
  return positions;
}

double SoftHand::energy() const {
  return flesh_.energy(nodes_) + bodies_.kineticEnergy() + bodies_.couplingEnergy(target_);
}

}  // namespace tactile_clay::hand
