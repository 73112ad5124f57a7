#include "hand/one_euro.h"

#include <cmath>

namespace tactile_clay::hand {

double lowPassGain(double cutoff, double te) {
  return 1.0 / (1.0 + 1.0 / (2.0 * M_PI * cutoff * te));
}

Eigen::Vector3d rotationVector(const Eigen::Quaterniond& q) {
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2.0 * (q.w() < 0.0 ? -1.0 : 1.0) * q.vec();
  // atan2 of the absolute values: of q and -q, the one that turns less.
  const double angle = 2.0 * std::atan2(sine, std::abs(q.w()));
  return (q.w() < 0.0 ? -angle : angle) / sine * q.vec();
}

Eigen::Quaterniond rotation(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle < 1e-12) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

Eigen::Quaterniond OneEuroRotation::filter(const Eigen::Quaterniond& q, double te,
                                           const OneEuroConfig& config) {
  const Eigen::Vector3d turn = rotationVector(value_.conjugate() * q.normalized());
  derivative_ += lowPassGain(config.derivative_cutoff, te) * (turn / te - derivative_);
  const double cutoff = config.min_cutoff + config.beta * derivative_.norm();
  value_ = (value_ * rotation(lowPassGain(cutoff, te) * turn)).normalized();
  return value_;
}

}  // namespace tactile_clay::hand
