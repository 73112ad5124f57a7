#pragma once

#include <Eigen/Geometry>

namespace tactile_clay::hand {

/// Parameters of the One-Euro filter (Casiez, Roussel & Vogel 2012). The unit of `beta` is 1 / (unit of the
/// signal): 0.1 per mm is 100 per m.
struct OneEuroConfig {
  double min_cutoff = 1.0;         // Hz, of a signal at rest; infinite: no filter
  double beta = 0.0;               // Hz per unit of speed, that is 1 / (unit of the signal)
  double derivative_cutoff = 1.0;  // Hz
};

/// Gain of a first-order low-pass of this cutoff, Hz, for a sample `te` s after the last:
/// 1 / (1 + 1/(2 pi cutoff te)).
double lowPassGain(double cutoff, double te);

/// One-Euro filter of a vector. All coordinates share one cutoff, by the norm of the speed, so that the
/// result does not depend on the axes. With one coordinate it is the authors' filter. The derivative is taken
/// between the sample and the last filtered value, as in the authors' reference.
template <int N>
class OneEuro {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  void reset(const Vector& x) {
    value_ = x;
    derivative_.setZero();
  }
  /// @param te s since the sample before, positive
  Vector filter(const Vector& x, double te, const OneEuroConfig& config) {
    derivative_ += lowPassGain(config.derivative_cutoff, te) * ((x - value_) / te - derivative_);
    const double cutoff = config.min_cutoff + config.beta * derivative_.norm();
    const double gain = lowPassGain(cutoff, te);
    value_ = gain * x + (1.0 - gain) * value_;
    return value_;
  }
  const Vector& value() const { return value_; }

 private:
  Vector value_ = Vector::Zero();
  Vector derivative_ = Vector::Zero();
};

/// One-Euro filter of a rotation, applied to the rotation vector (quaternion log) from the last filtered
/// rotation; `beta` is per rad.
class OneEuroRotation {
 public:
  void reset(const Eigen::Quaterniond& q) {
    value_ = q.normalized();
    derivative_.setZero();
  }
  Eigen::Quaterniond filter(const Eigen::Quaterniond& q, double te, const OneEuroConfig& config);
  const Eigen::Quaterniond& value() const { return value_; }

 private:
  Eigen::Quaterniond value_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d derivative_ = Eigen::Vector3d::Zero();
};

/// Rotation vector, rad, of the shorter way that q turns.
Eigen::Vector3d rotationVector(const Eigen::Quaterniond& q);
/// The rotation with this rotation vector.
Eigen::Quaterniond rotation(const Eigen::Vector3d& vector);

}  // namespace tactile_clay::hand
