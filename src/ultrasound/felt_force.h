#pragma once

#include "ultrasound/acoustics.h"
#include "ultrasound/focus_beam.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::ultrasound {

/// Area of a focus: force over peak radiation pressure, m^2. For a square aperture whose directions s span W
/// along each side, it is lambda^2 / W^2 (Parseval's theorem; the pattern is a sinc along each side). W^2 is
/// 12 times the variance of s along a side.
double spotArea(const Acoustics& acoustics, const FocusBeam& beam);

/// What people feel of a radiation force, by published experiments. 0: not known for this modulation.
struct FeltForce {
  double vibration = 0.0;  // dB above what a finger just feels; 0 also below that
  double pressure = 0.0;   // N of a steady touch that feels equally strong
};

/// - Vibration, for AM and fields from 150 to 250 Hz: in relation to the threshold of a finger, 0.4 mN of
///   radiation force that is switched on and off 200 times per second (Dalecki et al. 1995, doi
///   10.1121/1.411877).
/// - Pressure, for lateral modulation: a focus that moves to and fro at 5 to 15 Hz in steps of less than 1 mm
///   and presses with 0.027 N was felt like 0.21 N (Morisaki et al. 2022, doi 10.1109/TOH.2021.3125843).
/// - Pressure, for circles from 4 to 6 Hz: foci that went round a circle of 3 mm radius at 5 Hz were felt
///   like 0.24 N, 10.9 times the force with which they pressed (Morisaki et al. 2024, doi
///   10.1109/TOH.2023.3338230).
///
/// @param frequency of the modulation, Hz
/// @param force N, while the sound is on
FeltForce feltForce(Modulation modulation, double frequency, double force);

}  // namespace tactile_clay::ultrasound
