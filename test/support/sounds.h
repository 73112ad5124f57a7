#pragma once

#include <utility>

#include "device/array_device.h"

namespace tactile_clay::device {

/// What a gate that lowers nothing would return.
/// @param device asked for its drives, or null
inline Sound soundOf(const Emission& emission, const ArrayDevice* device = nullptr) {
  Sound sound{emission, {}};
  for (ultrasound::Part& part : ultrasound::parts(period(emission))) {
    Sound::Part played;
    if (device != nullptr) {
      if (auto drive = device->drive(part.points)) played.drive = std::move(*drive);
    }
    played.what = std::move(part);
    sound.parts.push_back(std::move(played));
  }
  return sound;
}

}  // namespace tactile_clay::device
