#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

namespace tactile_clay::hand {

struct RigidFit {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // pose of the frame of `from` in that of `to`
  double rms = 0.0;                                        // m, root mean square of the remaining distances
  double worst = 0.0;                                      // m, the largest remaining distance
};

/// Rotation and translation, without scale, that bring points `from` onto points `to` with the least sum of
/// squares (Umeyama 1991).
/// @throws std::invalid_argument with one line if the lists differ in length or contain fewer than three
/// points or a number that is not finite, or if the points lie on one line
RigidFit fitRigid(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to);

/// Finds places where a fingertip rests: for `seconds` it stays within `radius` of its mean position. This
/// position is at least `apart` from the place found before.
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
  /// @return the mean position, if the sample completes such a rest
  std::optional<Eigen::Vector3d> add(double time, const Eigen::Vector3d& tip);
  /// To be called if the finger is not seen.
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
