#include "hand/calibration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "hand/rigid_motion.h"

namespace tactile_clay::hand {
namespace {

// m; points with a smaller root mean square distance from a line count as one line. A triangle of 5 cm sides
// has 20 mm. An error of 2 mm in a touch then turns the tracker by 0.1 rad.
constexpr double narrowest = 0.02;

// Root of the second largest variance: the spread of the points beside their longest direction.
double spread(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  const Eigen::Matrix3d covariance = centred * centred.transpose() / static_cast<double>(points.cols());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> variances(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(variances.eigenvalues()[1], 0.0));  // by rounding it may be negative
}

Eigen::Matrix3Xd columns(const std::vector<Eigen::Vector3d>& points, const char* what) {
  Eigen::Matrix3Xd matrix(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) matrix.col(static_cast<Eigen::Index>(i)) = points[i];
  if (!matrix.allFinite())
    throw std::invalid_argument(std::string("calibration: a ") + what +
                                " point is not finite, expected metres");
  if (spread(matrix) < narrowest)
    throw std::invalid_argument(std::string("calibration: the ") + what +
                                " points lie on one line, expected a triangle of 5 cm or more");
  return matrix;
}

}  // namespace

RigidFit fitRigid(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to) {
  if (from.size() != to.size() || from.size() < 3)
    throw std::invalid_argument("calibration: " + std::to_string(from.size()) + " touched and " +
                                std::to_string(to.size()) +
                                " marked points, expected as many of each, 3 at least");
  const Eigen::Matrix3Xd a = columns(from, "touched"), b = columns(to, "marked");
  RigidFit fit;
  fit.pose = rigidMotion(a, b);
  const Eigen::RowVectorXd distances =
      (fit.pose.matrix().topRows<3>() * a.colwise().homogeneous() - b).colwise().norm();
  fit.rms = std::sqrt(distances.squaredNorm() / static_cast<double>(distances.size()));
  fit.worst = distances.maxCoeff();
  return fit;
}

std::optional<Eigen::Vector3d> TouchDetector::add(double time, const Eigen::Vector3d& tip) {
  samples_.push_back({time, tip});
  // Only as many old samples stay as `seconds` needs.
  const auto old = std::find_if(samples_.rbegin(), samples_.rend(),
                                [&](const Sample& sample) { return sample.time <= time - config_.seconds; });
  if (old == samples_.rend()) return std::nullopt;
  samples_.erase(samples_.begin(), std::prev(old.base()));
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Sample& sample : samples_) mean += sample.tip / static_cast<double>(samples_.size());
  for (const Sample& sample : samples_)
    if (!((sample.tip - mean).norm() <= config_.radius)) return std::nullopt;
  if (last_ && (mean - *last_).norm() < config_.apart) return std::nullopt;
  last_ = mean;
  samples_.clear();
  return mean;
}

Eigen::Vector3d rollPitchYaw(const Eigen::Matrix3d& r) {
  const double pitch = std::atan2(-r(2, 0), std::hypot(r(2, 1), r(2, 2)));
  // Looking straight up or down, roll and yaw are one rotation. All of it is given to yaw.
  if (std::hypot(r(2, 1), r(2, 2)) < 1e-9) return {0.0, pitch, std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

std::string trackerPoseLine(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d p = pose.translation(), angles = rollPitchYaw(pose.linear());
  std::string numbers;
  for (const double number : {p.x(), p.y(), p.z(), angles.x(), angles.y(), angles.z()}) {
    const double rounded = std::round(number * 1e5) / 1e5 + 0.0;  // avoids "-0.00000"
    char text[32];
    std::snprintf(text, sizeof text, "%.5f", rounded);
    numbers += (numbers.empty() ? "" : ", ") + std::string(text);
  }
  return "tracker_pose: [" + numbers + "]";
}

std::string withTrackerPose(const std::string& yaml, const Eigen::Isometry3d& pose) {
  std::istringstream lines(yaml);
  std::string result, line;
  bool replaced = false;
  while (std::getline(lines, line)) {
    const bool it = line.rfind("tracker_pose:", 0) == 0;
    result += (it ? trackerPoseLine(pose) : line) + "\n";
    replaced = replaced || it;
  }
  return replaced ? result : result + trackerPoseLine(pose) + "\n";
}

}  // namespace tactile_clay::hand
