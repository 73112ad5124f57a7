#pragma once

#include "ultrasound/acoustics.h"
#include "ultrasound/focus_beam.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::ultrasound {

/// Area over which the radiation pressure of a focus adds up to its force: force over peak pressure, m^2.
/// A square aperture of W in the directions s has lambda^2 / W^2 (Parseval's theorem; the pattern is a sinc
/// along each side), and W^2 is 12 times the variance of s along a side.
double spotArea(const Acoustics& acoustics, const FocusBeam& beam);

/// What people feel of a radiation force, by published experiments. 0: not known for this modulation.
struct FeltForce {
  double vibration = 0.0;  // dB above what a finger just feels; 0 also below that
  double pressure = 0.0;   // N of a steady touch that is felt as strong
};

/// Vibration: over the threshold of a finger, 0.4 mN of radiation force that is switched on and off 200 times
/// a second (Dalecki et al. 1995, doi 10.1121/1.411877); for AM and fields from 150 to 250 Hz. Pressure: a
/// focus that moves to and fro at 5 to 15 Hz in steps of less than 1 mm was felt like 0.21 N where it pressed
/// with 0.027 N (Morisaki et al. 2022, doi 10.1109/TOH.2021.3125843); for lateral modulation. Foci that went
/// round a circle of 3 mm radius at 5 Hz were felt like 0.24 N, 10.9 times what they pressed with (Morisaki
/// et al. 2024, doi 10.1109/TOH.2023.3338230); for circles from 4 to 6 Hz.
/// @param frequency of the modulation, Hz
/// @param force N, while the sound is on
FeltForce feltForce(Modulation modulation, double frequency, double force);

}  // namespace tactile_clay::ultrasound
