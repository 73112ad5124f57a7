#pragma once

#include <Eigen/Core>
#include <vector>

#include "contact/pressure_field.h"

namespace tactile_clay::ultrasound {

/// A place on the skin that stands for the skin around it.
struct SkinSample {
  Eigen::Vector3d position;  // m
  double pressure;           // Pa, mean over what it stands for, by area
  double area;               // m^2 of that
  double weight = 1.0;       // perceptual, 0-1, mean by area
};

/// Samples of skin that stand for all of it: all of them, where they are no more than `maximum`, or else some
/// so many, each for as large an area as the others. They are not denser where skin feels more finely: fields
/// that the palm has fewer samples of are worse on all of the skin, also by perceptual weights
/// (doc/logbook/rendering.md).
///
/// Skin of more samples is cut into pieces of that area along a curve through cells of 4 mm that passes
/// neighbours one after the other (Morton 1966), and each piece is told by the sample in its middle, at the
/// mean pressure of the piece. Pressed and bare skin are cut apart, and each has one piece at least.
/// Deterministic; does not depend on the order of the samples.
/// @param skin of positive finite area
/// @param maximum samples, at least 1; one more where each part is smaller than a piece
std::vector<SkinSample> skinSamples(const std::vector<contact::PressureSample>& skin, std::size_t maximum);

}  // namespace tactile_clay::ultrasound
