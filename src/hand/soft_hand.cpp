#include "hand/soft_hand.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "hand/anatomy.h"
#include "hand/hand_check.h"
#include "hand/hand_pose.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double farthest_jump = 0.5;      // m between two samples; the hand starts anew there
constexpr double longest_frame = 0.1;      // s simulated for one sample
constexpr double load_lifetime = 0.1;      // s
constexpr double resize_from = 0.01;       // relative change of the person's size
constexpr float strongest = 5.0F;          // N, on one sample
constexpr float strongest_of_all = 50.0F;  // N, on a hand: leaning on a table is less
constexpr float friction = 1.0F;           // what a load may resist sideways, of its force inward
constexpr float softest_clay = 200.0F;     // N/m at one sample
constexpr float stiffest_clay = 10000.0F;  // N/m at one sample
constexpr float first_guess = 1000.0F;     // N/m
constexpr float forgetting = 0.97F;        // of the stiffness estimate, a frame
constexpr int longest_memory = 12;         // frames that a place which let go is approached with care
constexpr float healing = 0.3F;            // of the way back, a step and inverted tetrahedron
constexpr float newest = 0.8F;             // share of the newest answer of the clay in what acts
constexpr std::size_t remembered = 16;     // skins
constexpr double seconds_a_nano = 1e-9;

void requireIn(const char* what, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw std::invalid_argument("soft hand: " + std::string(what) + " is " + std::to_string(value) +
                                ", expected " + std::to_string(low) + " to " + std::to_string(high));
}

// Closest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5), barycentric.
Vector3d closestShare(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0.0, 1.0 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

// Axes of a sample: along the smooth normal, and along an edge as far as it is square to it.
Eigen::Matrix3f frameOf(const Vector3f& normal, const Vector3f& edge) {
  Eigen::Matrix3f frame;
  frame.col(2) = normal;
  const Vector3f flat = edge - edge.dot(normal) * normal;
  frame.col(0) = flat.norm() > 1e-7F ? Vector3f(flat.normalized()) : normal.unitOrthogonal();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

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
  m[palm_body] = 0.25;  // the palm, without what of the arm moves with it
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
      bodies_(parameters.couplings, masses(anatomy_->rest, parameters.density), gyrations(anatomy_->rest)) {
  const std::size_t count = anatomy_->mesh.nodes.size();
  nodes_.assign(count + unused_flesh_nodes, FleshNode::Zero());
  std::array<int, body_count> of_body{};
  std::array<double, body_count> square{};
  for (std::size_t n = 0; n < count; ++n) {
    const NodeBinding& binding = anatomy_->bindings[n];
    nodes_[n].head<3>() = anatomy_->mesh.nodes[n].cast<float>();
    if (!binding.rigid) continue;
    rigid_.push_back(static_cast<int>(n));
    ++of_body[binding.body];
    square[binding.body] += (anatomy_->mesh.nodes[n] - centre_[binding.body]).squaredNorm();
  }
  // So light that all nodes together turn and move no harder than the body: collecting them then only damps.
  for (const int n : rigid_) {
    const int b = anatomy_->bindings[n].body;
    const double g = bodies_.gyration(b);
    rigid_share_.push_back(std::min(1.0 / of_body[b], g * g / square[b]));
  }
  in_body_.resize(rigid_.size());
  stiffness_.fill(first_guess);
  bindSkin(skin, skin_scale);
  resize(skin_scale);
}

void SoftHand::bindSkin(const Skin& skin, double skin_scale) {
  const FleshMesh& mesh = anatomy_->mesh;
  const std::vector<Vector3f> normals = smoothNormals();
  const auto side = static_cast<std::uint8_t>(anatomy_->rest.side);
  const auto shrink = static_cast<float>(1.0 / skin_scale);
  for (std::size_t i = 0; i < skin.size(); ++i) {
    if (skin.side[i] != side) continue;
    const Joint region = static_cast<Joint>(skin.region[i]);
    const Vector3d x = skin.position[i].cast<double>() / skin_scale;
    const int part = fleshPart(region);
    double closest = std::numeric_limits<double>::infinity();
    int triangle = -1;
    Vector3d share;
    for (int t = anatomy_->part_begin[part]; t < anatomy_->part_begin[part + 1]; ++t) {
      const auto& n = mesh.triangles[t];
      const Vector3d &a = mesh.nodes[n[0]], &b = mesh.nodes[n[1]], &c = mesh.nodes[n[2]];
      if ((b - a).cross(c - a).dot(skin.normal[i].cast<double>()) <= 0.0) continue;
      const Vector3d s = closestShare(x, a, b, c);
      const double d = (s[0] * a + s[1] * b + s[2] * c - x).squaredNorm();
      if (d < closest) closest = d, triangle = t, share = s;
    }
    if (triangle < 0) throw std::logic_error("soft hand: skin without flesh beneath");
    BoundSkinSample sample;
    sample.node = mesh.triangles[triangle];
    sample.share = share.cast<float>();
    Vector3f normal = Vector3f::Zero();
    Vector3d on = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      normal += sample.share[k] * normals[sample.node[k]];
      on += share[k] * mesh.nodes[sample.node[k]];
    }
    const Vector3d ab = mesh.nodes[sample.node[1]] - mesh.nodes[sample.node[0]];
    const Vector3d ac = mesh.nodes[sample.node[2]] - mesh.nodes[sample.node[0]];
    const Eigen::Matrix3f frame = frameOf(normal.normalized(), ab.cast<float>());
    sample.offset = frame.transpose() * (x - on).cast<float>();
    sample.normal = frame.transpose() * skin.normal[i];
    sample.triangle_area = static_cast<float>(0.5 * ab.cross(ac).norm());
    sample.area = shrink * shrink * skin.area[i];
    sample.pad_distance = shrink * skin.pad_distance[i];
    sample.region = skin.region[i];
    sample.body = static_cast<std::uint8_t>(anatomy_->bindings[sample.node[0]].body);
    samples_.push_back(sample);
  }
}

void SoftHand::resize(double scale) {
  scale_ = scale;
  flesh_.rest(scale);
  const std::vector<double> stiffness = flesh_.stiffness();
  for (std::size_t n = 0; n < stiffness.size(); ++n)
    if (stiffness[n] > 0.0) nodes_[n][3] = static_cast<float>(1.0 / (parameters_.relaxation * stiffness[n]));
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int n = rigid_[i];
    in_body_[i] = scale * (anatomy_->mesh.nodes[n] - centre_[anatomy_->bindings[n].body]);
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

void SoftHand::place(const TrackedHand& hand) {
  resize(std::clamp(personScale(hand), 0.4, 2.0));
  target_ = bodyPoses(hand, anatomy_->rest);
  bodies_.place(target_);
  for (std::size_t n = 0; n < anatomy_->bindings.size(); ++n)
    nodes_[n].head<3>() = skinned(static_cast<int>(n), target_).cast<float>();
  rememberPoints();
  unload();
  stiffness_.fill(first_guess);
}

void SoftHand::advance(const TrackedHand& hand, double dt) {
  const double scale = std::clamp(personScale(hand), 0.4, 2.0);
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
  if (!sane()) {
    place(hand);
    ++restarts_;
  }
}

bool SoftHand::sane() const {
  for (std::size_t n = 0; n < anatomy_->bindings.size(); ++n)
    if (!((nodes_[n].head<3>().cast<double>() - target_[palm_body].position).norm() < 1.0)) return false;
  return true;
}

void SoftHand::step(const BodyPoses& target, const BodyPoses& before, double h) {
  const BodyPoses start = bodies_.poses();
  bodies_.predict(target, before, h);
  carryFlesh(start);
  carryBones();
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int b = anatomy_->bindings[rigid_[i]].body;
    nodes_[rigid_[i]][3] = static_cast<float>(h * h / (bodies_.mass(b) * rigid_share_[i]));
  }
  applyLoads();
  flesh_.project(nodes_, inverted_, squeezed_);
  projectLoads();
  rememberPoints();
  const BodyPoses predicted = bodies_.poses();
  collect(h);
  bodies_.closeJoints();
  bodies_.finish(h);
  carryFlesh(predicted);
  carryBones();
  heal();
}

// Flesh that was torn inside out, as by a pose that no hand can take, may be caught by its neighbours: it is
// led back to where its bones would put it. Not on a bone that the clay presses: what leads it there would
// carry the load beside the bone.
void SoftHand::heal() {
  std::array<bool, body_count> pressed{};
  for (const SkinLoad& load : loads_) pressed[samples_[load.sample].body] = true;
  for (const int n : inverted_) {
    const NodeBinding& binding = anatomy_->bindings[n];
    if (binding.rigid || pressed[binding.body]) continue;
    const Vector3f home = skinned(n, bodies_.poses()).cast<float>();
    nodes_[n].head<3>() += healing * (home - nodes_[n].head<3>());
  }
}

// Flesh goes where its bones have gone since `from`.
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

// What flesh and loads did to the nodes of bone, they do to the body. In the pass over the flesh each of
// these nodes gives way by itself, more than the whole bone does: flesh that the clay squeezes against it
// gets its least volume where the bone really is.
void SoftHand::collect(double h) {
  std::array<Vector3d, body_count> impulse, moment;
  impulse.fill(Vector3d::Zero());
  moment.fill(Vector3d::Zero());
  std::vector<Vector3d> each(rigid_.size());  // kg m
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int b = anatomy_->bindings[rigid_[i]].body;
    FleshNode& node = nodes_[rigid_[i]];
    const Vector3d at = bodies_.poses()[b].position + bodies_.poses()[b].rotation * in_body_[i];
    each[i] = bodies_.mass(b) * rigid_share_[i] * (node.head<3>().cast<double>() - at);
    node << at.cast<float>(), 0.0F;
  }
  if (!loads_.empty() && !squeezed_.empty()) {
    reaction_.assign(nodes_.size(), Vector3f::Zero());
    flesh_.limit(squeezed_, nodes_, reaction_);
    for (std::size_t i = 0; i < rigid_.size(); ++i) each[i] += h * h * reaction_[rigid_[i]].cast<double>();
  }
  for (std::size_t i = 0; i < rigid_.size(); ++i) {
    const int b = anatomy_->bindings[rigid_[i]].body;
    impulse[b] += each[i];
    moment[b] += (bodies_.poses()[b].rotation * in_body_[i]).cross(each[i]);
  }
  for (int b = 0; b < body_count; ++b) bodies_.push(b, impulse[b], moment[b]);
}

Vector3f SoftHand::point(const BoundSkinSample& s) const {
  return s.share[0] * nodes_[s.node[0]].head<3>() + s.share[1] * nodes_[s.node[1]].head<3>() +
         s.share[2] * nodes_[s.node[2]].head<3>();
}

void SoftHand::rememberPoints() {
  points_.clear();
  for (const BoundSkinSample& sample : samples_) points_.push_back(point(sample));
}

void SoftHand::load(const std::vector<SkinForce>& forces, const std::vector<Vector3f>& at) {
  std::vector<SkinLoad> next;
  next.reserve(forces.size());
  float sum = 0.0F;
  for (const SkinForce& f : forces) sum += std::min(strongest, f.force.stableNorm());
  const float share = std::min(1.0F, strongest_of_all / std::max(sum, 1e-6F));
  for (const SkinForce& f : forces) {
    const int sample = static_cast<int>(f.index);
    const float size = f.force.stableNorm();
    if (size == 0.0F) continue;
    const Vector3f force = share * std::min(1.0F, strongest / size) * f.force;
    next.push_back({sample, force, force / force.norm(), at[sample], 0, 0.0F, force});
  }
  std::vector<bool> taken(samples_.size(), false);
  for (const SkinLoad& load : next) taken[load.sample] = true;
  for (const SkinLoad& old : loads_)
    if (!taken[old.sample] && old.age < longest_memory)
      next.push_back(
          {old.sample, Vector3f::Zero(), old.inward, at[old.sample], old.age + 1, 0.0F, Vector3f::Zero()});
  std::sort(next.begin(), next.end(),
            [](const SkinLoad& a, const SkinLoad& b) { return a.sample < b.sample; });
  estimateStiffness(next, at);
  average(next, at);
}

// The clay answers moving skin in jolts. Pairs of force and place are averaged, so that clay at rest is felt
// as it is.
void SoftHand::average(std::vector<SkinLoad>& next, const std::vector<Vector3f>& at) {
  if (loads_at_.size() != at.size()) {
    loads_at_ = at;
  } else {
    std::vector<Vector3f> before(samples_.size(), Vector3f::Zero());
    for (const SkinLoad& load : loads_) before[load.sample] = load.force;
    for (std::size_t i = 0; i < at.size(); ++i) loads_at_[i] += newest * (at[i] - loads_at_[i]);
    for (SkinLoad& load : next) {
      load.at = loads_at_[load.sample];
      if (load.age > 0) continue;  // what is let go of is free at once
      load.force = load.now = (1.0F - newest) * before[load.sample] + newest * load.force;
      load.inward = load.force.stableNormalized();
    }
  }
  loads_ = std::move(next);
}

// Least squares of -df = K dx, along the forces, over the samples of a body that are loaded now or were
// before. It rises at once and falls slowly: too high only makes the hand answer late, too low makes it ring.
void SoftHand::estimateStiffness(const std::vector<SkinLoad>& next, const std::vector<Vector3f>& at) {
  std::array<float, body_count> with{}, square{};
  const auto compare = [&](int sample, const Vector3f& before, const Vector3f& now) {
    const Vector3f direction = (before + now).stableNormalized();  // zero where neither presses
    const float dx = direction.dot(at[sample] - loads_at_[sample]);
    const int body = samples_[sample].body;
    with[body] -= dx * direction.dot(now - before);
    square[body] += dx * dx;
  };
  auto old = loads_.cbegin();
  auto fresh = next.cbegin();
  while (loads_at_.size() == at.size() && (old != loads_.cend() || fresh != next.cend())) {
    const int a = old == loads_.cend() ? std::numeric_limits<int>::max() : old->sample;
    const int b = fresh == next.cend() ? std::numeric_limits<int>::max() : fresh->sample;
    compare(std::min(a, b), a <= b ? old->force : Vector3f::Zero(), b <= a ? fresh->force : Vector3f::Zero());
    if (a <= b) ++old;
    if (b <= a) ++fresh;
  }
  for (int b = 0; b < body_count; ++b) {
    if (square[b] < 1e-14F) continue;
    const float estimate = std::max(with[b] / square[b], forgetting * stiffness_[b]);
    stiffness_[b] = std::clamp(estimate, softest_clay, stiffest_clay);
  }
}

void SoftHand::applyLoads() {
  for (SkinLoad& load : loads_) {
    const BoundSkinSample& s = samples_[load.sample];
    load.stiffness = stiffness_[s.body] * (1.0F - static_cast<float>(load.age) / (longest_memory + 1));
    for (int k = 0; k < 3; ++k) {
      FleshNode& n = nodes_[s.node[k]];
      n.head<3>() += n[3] * s.share[k] * load.now;
    }
  }
}

void SoftHand::projectLoads() {
  for (SkinLoad& load : loads_) {
    const BoundSkinSample& s = samples_[load.sample];
    float w = 0.0F;
    for (int k = 0; k < 3; ++k) w += s.share[k] * s.share[k] * nodes_[s.node[k]][3];
    const float compliance = 1.0F / load.stiffness;
    const Vector3f residual = -(point(s) - load.at) - compliance * (load.now - load.force);
    Vector3f now = load.now + residual / (w + compliance);
    // It presses or is gone; sideways it holds no more than friction does.
    const Vector3f& inward = load.inward;
    const float pressing = now.dot(inward);
    if (pressing <= 0.0F) {
      now.setZero();
    } else {
      const Vector3f aside = now - pressing * inward;
      const float size = aside.norm(), limit = friction * pressing;
      if (size > limit) now = pressing * inward + (limit / size) * aside;
    }
    const Vector3f change = now - load.now;
    load.now = now;
    for (int k = 0; k < 3; ++k) {
      FleshNode& n = nodes_[s.node[k]];
      n.head<3>() += n[3] * s.share[k] * change;
    }
  }
}

std::vector<Vector3f> SoftHand::smoothNormals() const {
  std::vector<Vector3f> normals(anatomy_->mesh.nodes.size(), Vector3f::Zero());
  for (const auto& t : anatomy_->mesh.triangles) {
    const Vector3f a = nodes_[t[0]].head<3>();
    const Vector3f n = (nodes_[t[1]].head<3>() - a).cross(nodes_[t[2]].head<3>() - a);
    for (const int k : t) normals[k] += n;
  }
  for (Vector3f& n : normals) n.stableNormalize();
  return normals;
}

void SoftHand::appendTo(Skin& skin) const {
  const std::vector<Vector3f> normals = smoothNormals();
  const auto scale = static_cast<float>(scale_);
  for (const BoundSkinSample& s : samples_) {
    const Vector3f a = nodes_[s.node[0]].head<3>();
    const Vector3f ab = nodes_[s.node[1]].head<3>() - a, ac = nodes_[s.node[2]].head<3>() - a;
    Vector3f normal =
        s.share[0] * normals[s.node[0]] + s.share[1] * normals[s.node[1]] + s.share[2] * normals[s.node[2]];
    const float size = normal.norm();
    normal = size > 1e-3F ? Vector3f(normal / size) : Vector3f(ab.cross(ac).stableNormalized());
    if (!(normal.squaredNorm() > 0.5F)) normal = Vector3f::UnitZ();
    const Eigen::Matrix3f frame = frameOf(normal, ab);
    const float stretch =
        std::clamp(0.5F * ab.cross(ac).norm() / (scale * scale * s.triangle_area), 0.25F, 4.0F);
    skin.position.push_back(point(s) + scale * (frame * s.offset));
    skin.normal.push_back((frame * s.normal).normalized());
    skin.velocity.push_back(Vector3f::Zero());
    skin.area.push_back(stretch * scale * scale * s.area);
    skin.pad_distance.push_back(scale * s.pad_distance);
    skin.side.push_back(static_cast<std::uint8_t>(anatomy_->rest.side));
    skin.region.push_back(s.region);
  }
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

Vector3d SoftHand::force() const {
  Vector3d sum = Vector3d::Zero();
  for (const SkinLoad& load : loads_) sum += load.now.cast<double>();
  return sum;
}

double SoftHand::energy() const {
  return flesh_.energy(nodes_) + bodies_.kineticEnergy() + bodies_.couplingEnergy(target_);
}

SoftHands::SoftHands(double spacing, const SoftHandParameters& parameters)
    : spacing_(spacing), parameters_(parameters) {
  requireIn("spacing of the skin (m)", spacing, 1e-3, 20e-3);
  requireIn("young (Pa)", parameters.young, 1e3, 1e6);
  requireIn("poisson", parameters.poisson, 0.0, 0.49);
  requireIn("density (kg/m^3)", parameters.density, 100.0, 10000.0);
  requireIn("relaxation", parameters.relaxation, 0.01, 100.0);
  requireIn("finger_cell (m)", parameters.finger_cell, 2e-3, 10e-3);
  requireIn("palm_cell (m)", parameters.palm_cell, 2e-3, 15e-3);
  requireIn("step (s)", parameters.step, 1e-4, 0.02);
  requireIn("stiffness of the palm's coupling (N/m)", parameters.couplings.palm, 1.0, 1e5);
  requireIn("stiffness of the fingers' couplings (N/m)", parameters.couplings.finger, 1.0, 1e5);
}

const Skin& SoftHands::update(const std::vector<TrackedHand>& hands_in_world,
                              std::chrono::nanoseconds stamp) {
  for (const TrackedHand& hand : hands_in_world) {
    const std::string fault = faultOf(hand);
    if (!fault.empty()) throw std::invalid_argument(fault);
  }
  std::vector<TrackedHand> hands = hands_in_world;
  keepOneHandASide(hands);
  std::sort(hands.begin(), hands.end(), [](const auto& a, const auto& b) { return a.side < b.side; });
  const bool stale = seconds_a_nano * static_cast<double>((stamp - loads_stamp_).count()) > load_lifetime;
  skin_ = Skin();
  Past past{stamp, ++number_, {}};
  std::array<bool, 2> seen{};
  for (const TrackedHand& hand : hands) {
    const int side = static_cast<int>(hand.side);
    seen[side] = true;
    std::optional<Present>& present = hands_[side];
    const Vector3d& palm_position = hand.joints[palm].position;
    bool goes_on = present.has_value() && (palm_position - present->palm_position).norm() <= farthest_jump;
    if (!present) {
      auto& anatomy = templates_[side];
      if (!anatomy)
        anatomy = std::make_shared<SoftHandTemplate>(
            makeSoftHandTemplate(hand.side, parameters_.finger_cell, parameters_.palm_cell));
      const double scale = std::clamp(personScale(hand), 0.4, 2.0);
      KinematicHands sampler(spacing_, false);  // flesh has no folds that the thumb could cover
      const Skin& skin = sampler.update({restHand(hand.side, scale)}, stamp);
      present.emplace(
          Present{SoftHand(anatomy, skin, scale, parameters_), palm_position, stamp, number_, {}});
    }
    const double dt = seconds_a_nano * static_cast<double>((stamp - present->stamp).count());
    if (!goes_on) {
      present->soft.place(hand);
      present->since = number_;
    } else if (dt > 0.0) {
      if (stale) present->soft.unload();
      present->soft.advance(hand, dt);
    }
    Skin skin;
    present->soft.appendTo(skin);
    if (goes_on && dt > 0.0)
      for (std::size_t i = 0; i < skin.size(); ++i)
        skin.velocity[i] = (skin.position[i] - present->skin.position[i]) / static_cast<float>(dt);
    const auto join = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    join(skin_.position, skin.position);
    join(skin_.normal, skin.normal);
    join(skin_.velocity, skin.velocity);
    join(skin_.area, skin.area);
    join(skin_.pad_distance, skin.pad_distance);
    join(skin_.side, skin.side);
    join(skin_.region, skin.region);
    present->skin = std::move(skin);
    present->palm_position = palm_position;
    present->stamp = stamp;
    past.points[side] = present->soft.loadPoints();
  }
  for (int side = 0; side < 2; ++side)
    if (!seen[side]) hands_[side].reset();
  past_.push_back(std::move(past));
  if (past_.size() > remembered) past_.pop_front();
  return skin_;
}

std::size_t SoftHands::react(std::chrono::nanoseconds stamp, const std::vector<SkinForce>& forces) {
  const auto past =
      std::find_if(past_.rbegin(), past_.rend(), [&](const Past& p) { return p.stamp == stamp; });
  if (past == past_.rend()) return forces.size();
  const std::size_t left = past->points[0].size(), all = left + past->points[1].size();
  std::array<std::vector<SkinForce>, 2> of_side;
  std::size_t dropped = 0;
  for (SkinForce f : forces) {
    if (f.index >= all || !f.force.allFinite()) {
      ++dropped;
      continue;
    }
    const int side = f.index < left ? 0 : 1;
    if (side == 1) f.index -= static_cast<std::uint32_t>(left);
    of_side[side].push_back(f);
  }
  for (int side = 0; side < 2; ++side)
    // A hand that came anew since then was not in that skin.
    if (hands_[side] && hands_[side]->since <= past->number)
      hands_[side]->soft.load(of_side[side], past->points[side]);
  loads_stamp_ = stamp;
  return dropped;
}

}  // namespace tactile_clay::hand
