#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

namespace tactile_clay::hand {

struct RigidFit {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // of the frame of `from` in that of `to`
  double rms = 0.0;                                        // m, of the distances that remain
  double worst = 0.0;                                      // m
};

/// Rotation and translation, without scale, that bring points `from` onto points `to` with the least sum of
/// squares (Umeyama 1991).
/// @throws std::invalid_argument with one line where the lists differ in length, hold fewer than three points
/// or a number that is not finite, or where the points lie on one line
RigidFit fitRigid(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to);

/// Finds where a fingertip rests: it stays within `radius` of its mean for `seconds`, and was `apart` from
/// the place found before.
class TouchDetector {
 public:
  struct Config {
    double seconds = 0.7;
    double radius = 0.003;  // m
    double apart = 0.03;    // m
  };
  explicit TouchDetector(const Config& config) : config_(config) {}
  TouchDetector() : TouchDetector(Config{}) {}

  /// @param time s, increasing
  /// @return the mean place where one was found with this sample
  std::optional<Eigen::Vector3d> add(double time, const Eigen::Vector3d& tip);
  /// The finger is not seen.
  void lose() { samples_.clear(); }

 private:
  struct Sample {
    double time;
    Eigen::Vector3d tip;
  };
  Config config_;
  std::vector<Sample> samples_;
  std::optional<Eigen::Vector3d> last_;
};

/// Roll, pitch, yaw (rad) of R = Rz(yaw) Ry(pitch) Rx(roll), pitch within +-pi/2.
Eigen::Vector3d rollPitchYaw(const Eigen::Matrix3d& rotation);

/// "tracker_pose: [x, y, z, roll, pitch, yaw]", m and rad, as config/rig.yaml has it.
std::string trackerPoseLine(const Eigen::Isometry3d& pose);

/// `yaml` with its line of the key tracker_pose replaced, or with one added at its end; all else stays.
std::string withTrackerPose(const std::string& yaml, const Eigen::Isometry3d& pose);

}  // namespace tactile_clay::hand
