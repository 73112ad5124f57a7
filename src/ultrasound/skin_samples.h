#pragma once

#include <Eigen/Core>
#include <vector>

#include "contact/pressure_field.h"

namespace tactile_clay::ultrasound {

/// A place on the skin that stands for the skin around it.
struct SkinSample {
  Eigen::Vector3d position;                          // m
  double pressure;                                   // Pa, mean over the skin that it stands for, by area
  double area;                                       // m^2 of that skin
  double weight = 1.0;                               // perceptual, 0-1, mean by area
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // outward, unit, at the position
};

/// Samples of skin that stand for all skin. If there are at most `maximum` samples, all are returned;
/// otherwise about `maximum`, each for an area of the same size. They are not denser where skin feels more
/// finely: with fewer samples on the palm, fields are worse on all skin, also by perceptual weights
/// (doc/logbook/rendering.md).
///
/// Skin with more samples is cut into pieces of equal area along a curve through cells of 4 mm that passes
/// neighbours one after the other (Morton 1966). The sample in the middle of a piece represents it, with the
/// mean pressure of the piece and the normal at its own place. Pressed and bare skin are cut separately, and
/// each has at least one piece. Deterministic; does not depend on the order of the samples.
/// @param skin of positive finite area
/// @param maximum number of samples, at least 1; one more is returned if both pressed and bare skin are
/// smaller
///   than a piece, which needs a maximum of 1
std::vector<SkinSample> skinSamples(const std::vector<contact::PressureSample>& skin, std::size_t maximum);

}  // namespace tactile_clay::ultrasound
