#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactile_clay {

/// Samples of the skin of all hands (the paper's ghost particles, section III-D). Structure of arrays of one
/// length, in coordinate frame `world`. Arrays that a room does not use may be empty: the clay reads
/// position, normal and velocity; the computation of the pressure reads position, normal, area, weight and
/// the tracked arrays.
struct Skin {
  std::vector<Eigen::Vector3f> position;  // m
  std::vector<Eigen::Vector3f> normal;    // outward, unit
  std::vector<Eigen::Vector3f> velocity;  // m/s
  std::vector<float> area;                // m^2 of skin that the sample represents; 0 if other skin covers it
  std::vector<float> weight;              // perceptual, 0-1
  std::vector<float> pad_distance;        // m along the hand to the centre of the closest finger pad
  std::vector<std::uint8_t> side;         // 0 left, 1 right
  std::vector<std::uint8_t> region;       // hand::Joint at the proximal end of the bone under the sample

  /// If this is the skin of a virtual hand that the clay holds back: the same samples on the tracked hand, on
  /// which the pressure is felt. Empty if this is the skin of the tracked hand itself.
  std::vector<Eigen::Vector3f> tracked_position;  // m
  std::vector<Eigen::Vector3f> tracked_normal;    // outward, unit
  std::vector<float> tracked_area;                // m^2; 0 if other skin covers the sample

  std::size_t size() const { return position.size(); }
  bool isTracked() const { return tracked_position.empty(); }  // skin of the tracked hand itself
};

/// Force of the clay on a sample of the skin, mean over a frame: Eq. 6 summed over iterations, and friction.
struct SkinForce {
  std::uint32_t index = 0;                          // index of the sample in the skin
  Eigen::Vector3f force = Eigen::Vector3f::Zero();  // N, frame `world`
  // m/s at which the clay slides along the skin there: mean over the frame, weighted by the force.
  float slip = 0.0f;
};

}  // namespace tactile_clay
