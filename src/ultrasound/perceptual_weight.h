#pragma once

namespace tactile_clay::ultrasound {

constexpr double pad_radius = 0.008;  // m, of a finger pad

/// Perceptual weight alpha of a skin sample (Eq. 8), after the density of low-threshold mechanoreceptive
/// units: 241 units/cm^2 at the fingertip and 58 in the palm; palm : main part of the finger : fingertip = 1
/// : 1.6 : 4.2 (Johansson & Vallbo 1979, J. Physiol. 286:283-300, doi 10.1113/jphysiol.1979.sp012619).
///
///     alpha(d) = a + (1 - a) / (1 + (max(d - r, 0) / l)^2),   a = 58/241, r = 8 mm, l = 11.3 mm
///
/// It is 1 on the pad (radius r), falls with a continuous slope, and tends to the palm's share; l is such
/// that its mean over the main part of the finger, 15 to 65 mm from the pad, is 1.6/4.2.
/// @param pad_distance along the skin to the centre of the closest finger pad, m, not negative
/// @return weight in (0, 1]; the palm's share if the distance is not finite
double perceptualWeight(double pad_distance);

}  // namespace tactile_clay::ultrasound
