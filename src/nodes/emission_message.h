#pragma once

#include <tactile_clay/FocalPointArray.h>

#include "device/array_device.h"

namespace tactile_clay::nodes {

/// What a message asks of an array. Nothing of it is judged yet; a weight that it lacks is not a number, of
/// which the gate lets none pass.
device::Emission emissionOf(const FocalPointArray& message);

}  // namespace tactile_clay::nodes
