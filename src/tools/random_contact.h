#pragma once

#include <vector>

#include "contact/pressure_field.h"

namespace tactile_clay::tools {

/// A contact that depends on the seed, in the frame of an array 0.2 m below it. Odd seeds give one to four
/// finger tips with a radius of 8 mm, even seeds a tilted palm 70 mm wide. Pressure is as by Hertz, p = p0
/// sqrt(1 - (d / a)^2): finger tips have 15 to 30 kPa on 4 to 6 mm, the palm 5 to 10 kPa on 15 to 25 mm. The
/// result is the same on every computer.
/// @param step m, between samples
/// @return the pressed samples, then the bare ones around them
std::vector<contact::PressureSample> randomContact(unsigned seed, double step);

}  // namespace tactile_clay::tools
