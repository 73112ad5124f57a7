#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactile_clay::contact {

/// Force of the clay on one skin sample: Eq. 6 summed over the constraint iterations of a step.
struct ContactForce {
  std::uint32_t index = 0;                          // into the skin
  Eigen::Vector3f force = Eigen::Vector3f::Zero();  // N, frame world
};

/// Skin samples as the pressure needs them; arrays of one length, frame world.
struct SkinView {
  const std::vector<Eigen::Vector3f>& position;  // m
  const std::vector<Eigen::Vector3f>& normal;    // outward, unit
  const std::vector<float>& area;                // m^2
  const std::vector<float>& weight;              // perceptual, 0-1
};

struct PressureSample {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f normal;    // outward, unit
  float pressure;            // Pa
  float force;               // N, normal component
  float area;                // m^2
  float weight;              // perceptual, 0-1
};

/// Pressure on the skin that faces the array (Eq. 7): f_n = max(-n . f, 0), p = f_n / area. Only samples with
/// p > 0 are returned, in skin order, frame world. Forces on the same sample add up in the order given.
///
/// A contact whose force is not finite, or whose sample has a non-finite position, normal or weight or an
/// area that is not positive and finite, is left out and counted; it does not touch any other sample. So is a
/// sample whose pressure does not fit a float.
/// \param array_position of the centre of the array, m, world; a sample faces it where n . (array - x) > 0
/// \param dropped if given, receives the number of contacts left out for that reason
/// \throws std::out_of_range if a contact's index is not a sample of the skin
/// \throws std::invalid_argument if the skin's arrays differ in length or the array's position is not finite
std::vector<PressureSample> pressureField(const SkinView& skin, const std::vector<ContactForce>& contacts,
                                          const Eigen::Vector3f& array_position,
                                          std::size_t* dropped = nullptr);

}  // namespace tactile_clay::contact
