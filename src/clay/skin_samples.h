#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactile_clay::clay {

/// Samples of the skin at the end of a frame (ghost particles in the paper, section III-D); arrays of one
/// length.
struct SkinSamples {
  std::vector<Eigen::Vector3f> position;  // m, on the skin
  std::vector<Eigen::Vector3f> normal;    // outward, unit
  std::vector<Eigen::Vector3f> velocity;  // m/s; over the frame a sample moves straight to its position

  std::size_t size() const { return position.size(); }

  /// m, every coordinate of a sample that counts as not there.
  static constexpr float nowhere = 1e9f;
  bool exists(std::size_t i) const { return position[i].x() < nowhere; }
};

/// Force of the clay on a skin sample, mean over a frame: Eq. 6 summed over iterations, and friction.
struct SampleForce {
  std::uint32_t sample = 0;
  Eigen::Vector3f force = Eigen::Vector3f::Zero();  // N
  float slip = 0.0f;  // m/s, at which the clay slides along the skin there: mean over the frame by force
};

}  // namespace tactile_clay::clay
