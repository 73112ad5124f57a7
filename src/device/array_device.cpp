#include "device/array_device.h"

namespace tactile_clay::device {

std::vector<ultrasound::Instant> period(const Emission& emission) {
  if (emission.modulation == ultrasound::Modulation::amplitude && emission.modulation_frequency == 0.0)
    return {{emission.points, 1.0}};
  return ultrasound::period(emission.points, emission.modulation);
}

}  // namespace tactile_clay::device
