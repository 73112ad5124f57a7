#include "device/array_device.h"

#include "ultrasound/slip.h"

namespace tactile_clay::device {

namespace {

std::vector<ultrasound::Instant> withoutSlip(const Emission& emission) {
  if (emission.modulation == ultrasound::Modulation::amplitude && emission.modulation_frequency == 0.0)
    return {ultrasound::allAtOnce(emission.points)};
  return ultrasound::period(emission.points, emission.modulation);
}

}  // namespace

std::vector<ultrasound::Instant> period(const Emission& emission) {
  if (emission.points.empty()) return {};
  std::vector<ultrasound::Instant> instants = withoutSlip(emission);
  for (ultrasound::Instant& instant : instants)
    instant.amplitude = ultrasound::withSlip(instant.amplitude, emission.slip, ultrasound::slip_mean);
  return instants;
}

std::vector<const Sound::Part*> instants(const Sound& sound) {
  std::size_t count = 0;
  for (const Sound::Part& part : sound.parts) count += part.what.instants.size();
  std::vector<const Sound::Part*> played(count);
  for (const Sound::Part& part : sound.parts)
    for (const std::size_t instant : part.what.instants) played.at(instant) = &part;
  return played;
}

}  // namespace tactile_clay::device
