#include "clay/solver/lumps.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tactile_clay::clay {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;  // translation, rotation

constexpr double dents = 0.25;  // spacings; shorter moves into a collider make no dent
constexpr double thin = 1e-9;   // share of mass times size^2; minimum inertia about any axis

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace

void Lumps::measure(const StepInput& in) {
  const auto sums = moments_.of(in.near, in.particles.size(), [&](std::size_t i) {
    const double mass = 1.0 / in.particles.inverse_mass[i];
    const Eigen::Vector3d x = in.particles.position.at(i).cast<double>(), mx = mass * x;
    LumpSums<10>::Sum sum;
    sum << mass, mx, mx.x() * x, mx.y() * x.tail<2>(), mx.z() * x.z();
    return sum;
  });
  bodies_.resize(in.near.lumps());
  for (std::size_t l = 0; l < bodies_.size(); ++l) {
    const auto& sum = sums[l];
    Body& body = bodies_[l];
    body.mass = sum[0];
    body.centre = sum.segment<3>(1) / body.mass;
    Eigen::Matrix3d second;
    second << sum[4], sum[5], sum[6], sum[5], sum[7], sum[8], sum[6], sum[8], sum[9];
    second -= body.mass * body.centre * body.centre.transpose();
    body.inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
    // Far from the origin the inertia is the difference of large numbers.
    body.rounding = 64.0 * std::numeric_limits<double>::epsilon() * body.mass * body.centre.squaredNorm();
  }
}

/// Radius of gyration, m, at least a tenth of a spacing: the inertia of a single particle is only rounding.
double Lumps::size(const Body& body) const {
  return std::max(std::sqrt(0.5 * std::max(body.inertia.trace(), 0.0) / body.mass), 0.1 * spacing_);
}

/// Inertia to be added about each axis, kg m^2. A single particle has no inertia of its own, and a row of
/// particles none about its line; by rounding it may even be negative.
double Lumps::minInertia(const Body& body) const {
  return std::max(std::pow(size(body), 2) * body.mass * thin, body.rounding);
}

/// Momentum and angular momentum about its lump's centre that a particle has with this velocity.
LumpSums<6>::Sum Lumps::momentum(const StepInput& in, std::size_t i, const VectorField& velocity) const {
  const Eigen::Vector3d momentum = velocity.at(i).cast<double>() / in.particles.inverse_mass[i];
  LumpSums<6>::Sum both;
  both << momentum, armOf(in, i).cross(momentum);
  return both;
}

std::vector<Eigen::Matrix3f> Lumps::bends(const StepInput& in) {
  const auto momentum = momenta_.of(in.near, in.particles.size(), [&](std::size_t i) {
    return this->momentum(in, i, in.particles.velocity);
  });
  std::vector<Eigen::Matrix3f> turns(bodies_.size(), Eigen::Matrix3f::Zero());
  for (std::size_t l = 0; l < bodies_.size(); ++l) {
    const Body& body = bodies_[l];
    const Eigen::LDLT<Eigen::Matrix3d> inertia(body.inertia + minInertia(body) * Eigen::Matrix3d::Identity());
    const Eigen::Vector3d turn = in.dt * inertia.solve(momentum[l].tail<3>());
    const double sine = turn.norm();
    if (!(sine > 1e-6) || sine > 0.5) continue;
    // The velocities belong to the chords of the last step, x - R^-1 x. Those of the next step are R x - x.
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(std::asin(sine), turn / sine).toRotationMatrix();
    const Eigen::Matrix3d bend = rotation + rotation.transpose() - 2.0 * Eigen::Matrix3d::Identity();
    // The part of the bend that is itself a rotation is removed: the angular momentum is already right.
    const Eigen::Matrix3d second = 0.5 * body.inertia.trace() * Eigen::Matrix3d::Identity() - body.inertia;
    const Eigen::Matrix3d m = bend * second;
    const Eigen::Vector3d spun(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
    turns[l] = (bend - skew(inertia.solve(spun))).cast<float>();
  }
  return turns;
}

std::vector<Eigen::Vector3f> Lumps::falls(const StepInput& in, const VectorField& u,
                                          const Contacts& contacts) {
  struct Lump {
    Eigen::Matrix3d blocked = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), rubbing = force;  // N; rubbing: of contacts that slide
    Eigen::Vector3d slip = Eigen::Vector3d::Zero();                    // m, sum over contacts that slide
    int slides = 0;
  };
  std::vector<Lump> lumps(in.near.lumps());
  // Internal forces cancel within a lump, so only inertia and friction remain.
  const double per_square = 1.0 / (static_cast<double>(in.dt) * in.dt);
  const auto inertial = forces_.of(in.near, in.particles.size(), [&](std::size_t i) -> Eigen::Vector3d {
    return (in.free.at(i) - u.at(i)).cast<double>() * (per_square / in.particles.inverse_mass[i]);
  });
  for (std::size_t l = 0; l < lumps.size(); ++l) {
    lumps[l].force = inertial[l];
    lumps[l].inertia.diagonal().setConstant(bodies_[l].mass * per_square);
  }
  for (const Contact& c : contacts.contacts()) {
    if (c.state == Contact::State::open) continue;
    Lump& lump = lumps[in.near.lump(c.particle)];
    const Eigen::Vector3d normal = c.normal.cast<double>();
    lump.blocked += normal * normal.transpose();
    const Eigen::Vector3d friction = frictionOn(c, u.at(c.particle)).cast<double>();
    (c.state == Contact::State::slide ? lump.rubbing : lump.force) += friction;
    if (c.state == Contact::State::slide) {
      lump.slip += (u.at(c.particle) - c.drift).cast<double>();
      ++lump.slides;
    }
    if (c.state == Contact::State::stick) {
      lump.inertia += c.stiffness * (Eigen::Matrix3d::Identity() - normal * normal.transpose());
    }
  }
  std::vector<Eigen::Vector3f> moves(lumps.size(), Eigen::Vector3f::Zero());
  for (std::size_t l = 0; l < lumps.size(); ++l) {
    const Lump& lump = lumps[l];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> blocked(lump.blocked);
    Eigen::Vector3d move = Eigen::Vector3d::Zero(), back = move;  // back: due to sliding friction
    for (int k = 0; k < 3; ++k) {
      if (blocked.eigenvalues()[k] > 1e-4 * lump.blocked.trace()) continue;
      const Eigen::Vector3d direction = blocked.eigenvectors().col(k);
      const double inertia = direction.dot(lump.inertia * direction);
      move += lump.force.dot(direction) / inertia * direction;
      back += lump.rubbing.dot(direction) / inertia * direction;
    }
    // Sliding friction is still that of the last round or step. It can stop the slip, not reverse it.
    if (lump.slides > 0) {
      const double maximum = (move + lump.slip / lump.slides).norm(), length = back.norm();
      if (length > maximum) back *= maximum / length;
    }
    moves[l] = (move + back).cast<float>();
  }
  return moves;
}

std::vector<std::uint32_t> Lumps::meet(const StepInput& in, const VectorField& u, const Contacts& contacts,
                                       std::vector<Eigen::Vector3f>& moves) const {
  const float together = static_cast<float>(0.01 * spacing_), deep = static_cast<float>(dents * spacing_);
  const std::vector<Contact>& all = contacts.contacts();
  // Calls f(contact, way, slack) for contacts whose collider a lump would enter. It moves by `way` towards
  // the collider, m, and only `slack` of that is free.
  const auto for_approaches = [&](const auto& f) {
    for (std::uint32_t k = 0; k < all.size(); ++k) {
      const Contact& c = all[k];
      if (c.state != Contact::State::open) continue;
      const float way = -c.normal.dot(moves[in.near.lump(c.particle)]);
      const float slack = c.normal.dot(u.at(c.particle)) - c.gap;
      if (way > deep && slack < way) f(k, way, slack);
    }
  };
  std::vector<float> share(moves.size(), 1.0f);
  for_approaches([&](std::uint32_t k, float way, float slack) {
    float& minimum = share[in.near.lump(all[k].particle)];
    minimum = std::min(minimum, std::max(slack, 0.0f) / way);
  });
  std::vector<std::uint32_t> met;
  for_approaches([&](std::uint32_t k, float way, float slack) {
    if (slack <= share[in.near.lump(all[k].particle)] * way + together) met.push_back(k);
  });
  for (std::size_t l = 0; l < moves.size(); ++l) moves[l] *= share[l];
  return met;
}

std::vector<bool> Lumps::slideOnWhatRests(const StepInput& in, const Contacts& contacts) const {
  const float still = static_cast<float>(1e-4 * spacing_);
  std::vector<bool> touches(in.near.lumps(), false), held = touches;
  for (const Contact& c : contacts.contacts()) {
    const std::uint32_t l = in.near.lump(c.particle);
    if (c.state != Contact::State::open) touches[l] = true;
    if (c.drift.norm() > still || c.stiffness > 0.0f) held[l] = true;
  }
  for (std::size_t l = 0; l < touches.size(); ++l) touches[l] = touches[l] && !held[l];
  return touches;
}

std::vector<double> Lumps::workOfPushingOut(const StepInput& in, const Contacts& contacts) const {
  std::vector<double> work(in.near.lumps(), 0.0);
  for (const Contact& c : contacts.contacts())
    work[in.near.lump(c.particle)] += std::max(c.gap, 0.0f) * std::max(c.force.dot(c.normal), 0.0f);
  return work;
}

std::vector<double> Lumps::workOfRecovery(const StepInput& in, const Contacts& contacts) const {
  const double limited = 0.999 * ContactSearch::solid_recovery_speed * in.dt;
  std::vector<double> work(in.near.lumps(), 0.0);
  for (const Contact& c : contacts.contacts()) {
    const double recovered = c.gap - c.drift.dot(c.normal);
    if (c.solid != Contact::skin && recovered > limited)
      work[in.near.lump(c.particle)] += recovered * std::max(c.force.dot(c.normal), 0.0f);
  }
  return work;
}

/// For each lump a basis of the rigid motions (translation, rotation times its size) that no contact blocks.
std::vector<Lumps::Basis> Lumps::unblocked(const StepInput& in, const Contacts& contacts) const {
  constexpr double none = 1e-6;
  std::vector<Matrix6> blocked(bodies_.size(), Matrix6::Zero());
  const auto block = [&](const Contact& c, const Eigen::Vector3d& direction) {
    const std::uint32_t l = in.near.lump(c.particle);
    const Body& body = bodies_[l];
    const Eigen::Vector3d arm = in.particles.position.at(c.particle).cast<double>() - body.centre;
    LumpSums<6>::Sum motion;
    motion << direction, arm.cross(direction) / size(body);
    blocked[l] += motion * motion.transpose();
  };
  for (const Contact& c : contacts.contacts()) {
    if (c.state == Contact::State::open) continue;
    if (c.state == Contact::State::slide && !(c.damping > 0.0f)) {
      block(c, c.normal.cast<double>());
      continue;
    }
    for (int a = 0; a < 3; ++a) block(c, Eigen::Vector3d::Unit(a));
  }
  std::vector<Basis> bases(bodies_.size(), Basis::Identity(6, 6));
  for (std::size_t l = 0; l < bodies_.size(); ++l) {
    if (!(blocked[l].trace() > 0.0)) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix6> modes(blocked[l]);
    int count = 0;
    while (count < 6 && modes.eigenvalues()[count] < none * blocked[l].trace()) ++count;
    bases[l] = modes.eigenvectors().leftCols(count);
  }
  return bases;
}

/// The unblocked motion of a lump that has, along unblocked motions, the momentum times `scale`, kg m and
/// kg m^2.
Lumps::Motion Lumps::within(const Body& body, const Unblocked& motions, LumpSums<6>::Sum momentum,
                            double scale) const {
  const double length = size(body);
  momentum.tail<3>() /= length;
  const LumpSums<6>::Sum motion =
      scale * (motions.basis * motions.inertia.solve(motions.basis.transpose() * momentum));
  return {motion.head<3>(), motion.tail<3>() / length};
}

std::vector<Lumps::Unblocked> Lumps::unblockedMotions(const StepInput& in, const VectorField& u,
                                                      const Contacts& contacts) {
  std::vector<Basis> bases = unblocked(in, contacts);
  std::vector<Unblocked> motions(bodies_.size());
  if (std::none_of(bases.begin(), bases.end(), [](const auto& basis) { return basis.cols() > 0; }))
    return motions;
  const auto momenta =
      momenta_.of(in.near, in.particles.size(), [&](std::size_t i) { return momentum(in, i, u); });
  for (std::size_t l = 0; l < bodies_.size(); ++l) {
    if (bases[l].cols() == 0) continue;
    const Body& body = bodies_[l];
    // Rotations are in units of length, as in `unblocked`, where eigenvalues are compared.
    const double length = size(body);
    Matrix6 mass = Matrix6::Zero();
    mass.topLeftCorner<3, 3>().diagonal().setConstant(body.mass);
    mass.bottomRightCorner<3, 3>() = body.inertia / (length * length);
    mass.diagonal().array() += thin * body.mass;
    // the rest of the minimum inertia
    mass.diagonal().tail<3>().array() += std::max(body.rounding / (length * length) - thin * body.mass, 0.0);
    motions[l].inertia.compute(bases[l].transpose() * mass * bases[l]);
    motions[l].basis = std::move(bases[l]);
    motions[l].done = within(body, motions[l], momenta[l], 1.0);
  }
  return motions;
}

bool Lumps::findLacking(const StepInput& in, const VectorField& lack, const Contacts& contacts,
                        std::vector<Unblocked>& motions) {
  const auto is_free = [](const Unblocked& motion) { return motion.basis.cols() > 0; };
  if (std::none_of(motions.begin(), motions.end(), is_free)) return false;
  std::vector<bool> near_contact(bodies_.size(), false);
  for (const Contact& c : contacts.contacts()) near_contact[in.near.lump(c.particle)] = true;
  const auto momenta =
      momenta_.of(in.near, in.particles.size(), [&](std::size_t i) { return momentum(in, i, lack); });
  bool far = false;
  for (std::size_t l = 0; l < bodies_.size(); ++l) {
    // A lump that is near no collider lacks nothing. A lump that a contact turned lacks motion even if this
    // contact has opened since.
    if (!is_free(motions[l]) || !near_contact[l]) continue;
    const Motion lacking = within(bodies_[l], motions[l], momenta[l], static_cast<double>(in.dt) * in.dt);
    if (lacking.translation.norm() + 2.0 * size(bodies_[l]) * lacking.rotation.norm() < dents * spacing_)
      motions[l].lacking = lacking;
    else {
      motions[l].done = Motion();
      far = true;
    }
  }
  return far;
}

}  // namespace tactile_clay::clay
