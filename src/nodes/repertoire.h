#pragma once

#include <string>
#include <vector>

#include "device/array_device.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::nodes {

/// What an array can play.
struct Repertoire {
  std::string device;  // name of the device
  std::vector<ultrasound::Modulation> modulations;
  double max_rate = 0.0;       // updates per second that it takes, 0: any number
  std::size_t max_points = 0;  // focal points at a time, 0: any number
  bool slip = false;           // whether it plays Emission::slip

  /// Empty, or why the array cannot play this modulation, numbered as in FocalPointArray.
  std::string objection(unsigned modulation) const;

  /// Empty, or why the array cannot play the slip, or why there are too many points: phases and loudness of
  /// hundreds of points would take seconds, in which the node would judge nothing else.
  std::string objection(const device::Emission& emission) const;
};

}  // namespace tactile_clay::nodes
