#pragma once

#include <vector>

#include "contact/pressure_field.h"

namespace tactile_clay::tools {

/// A contact that follows from the seed, in the frame of an array 0.2 m below: by turns one to four finger
/// tips of 8 mm in radius, and a tilted palm 70 mm wide. Each is pressed as by Hertz, p = p0 sqrt(1 - (d /
/// a)^2), finger tips with 15 to 30 kPa on 4 to 6 mm, the palm with 5 to 10 kPa on 15 to 25 mm. The same on
/// every computer.
/// @param step m, of the samples
/// @return the pressed samples, then the bare ones around them
std::vector<contact::PressureSample> randomContact(unsigned seed, double step);

}  // namespace tactile_clay::tools
