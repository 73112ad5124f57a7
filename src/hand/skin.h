#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactile_clay::hand {

/// Samples of the skin of all hands (the paper's ghost particles), structure of arrays, frame `world`.
struct Skin {
  std::vector<Eigen::Vector3f> position;  // m
  std::vector<Eigen::Vector3f> normal;    // outward, unit
  std::vector<Eigen::Vector3f> velocity;  // m/s
  std::vector<float> area;                // m^2 of skin that it stands for; 0 where other skin covers it
  std::vector<float> pad_distance;        // m along the hand to the centre of the closest finger pad
  std::vector<std::uint8_t> side;         // 0 left, 1 right
  std::vector<std::uint8_t> region;       // hand::Joint at the proximal end of the bone under the sample

  /// The same samples on the tracked hand, which feels what touches them, where this is the skin of a virtual
  /// hand that the clay holds back. Empty where this is the skin of the tracked hand itself.
  std::vector<Eigen::Vector3f> tracked_position;  // m
  std::vector<Eigen::Vector3f> tracked_normal;    // outward, unit
  std::vector<float> tracked_area;                // m^2; 0 where other skin covers the sample

  std::size_t size() const { return position.size(); }
};

}  // namespace tactile_clay::hand
