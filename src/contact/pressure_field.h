#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "values/skin.h"

namespace tactile_clay::contact {

/// Pressure of the clay, and the place on the skin where it is to be felt.
struct PressureSample {
  Eigen::Vector3f position;  // m
  Eigen::Vector3f normal;    // outward, unit
  float pressure;            // Pa
  float force;               // N, normal component, where the skin met the clay
  float area;                // m^2, where it is felt
  float weight;              // perceptual, 0-1
  float slip = 0.0f;         // m/s, at which the clay slides along the skin there
};

/// Pressure on the skin that faces the array (Eq. 7): f_n = max(-n . f, 0), p = f_n / area. Only samples with
/// p > 0 are returned, in skin order, frame world. Forces on the same sample add up in the order given; the
/// slip of the sample is their mean slip, by the size of the forces.
///
/// Where the skin is not the tracked hand's own, the pressure arises where it meets the clay, by the normal
/// and the area there, and is returned with the place, normal and area on the tracked hand, where it is felt:
/// these decide whether it faces the array, and a sample that is covered there is left out, as is one whose
/// area is 0 because other skin covers it.
///
/// A contact whose force is not finite or whose slip is no finite number from 0, or whose sample has a
/// non-finite position, normal or weight or an area that is negative or not finite, is left out and counted;
/// it does not touch any other sample. So is a sample whose pressure does not fit a float, and one whose felt
/// place is not finite.
/// @param array_position of the centre of the array, m, world; a sample faces it where n . (array - x) > 0
/// @param dropped if given, receives the number of contacts left out for that reason
/// @throws std::out_of_range if a contact's index is not a sample of the skin
/// @throws std::invalid_argument if the skin's arrays differ in length or the array's position is not finite
std::vector<PressureSample> pressureField(const Skin& skin, const std::vector<SkinForce>& contacts,
                                          const Eigen::Vector3f& array_position,
                                          std::size_t* dropped = nullptr);

/// Skin that faces the array within `reach` of a pressed sample and is not pressed itself: samples of
/// pressure and force 0, in skin order, frame world, with places, normals and areas where they are felt.
/// Samples that are not usable (pressureField) are passed over.
/// @param pressed samples of the same skin, as pressureField returned them
/// @param reach m
/// @throws std::invalid_argument if the skin's arrays differ in length, or the array's position or the reach
/// is not finite
std::vector<PressureSample> skinAround(const Skin& skin, const std::vector<PressureSample>& pressed,
                                       const Eigen::Vector3f& array_position, float reach);

}  // namespace tactile_clay::contact
