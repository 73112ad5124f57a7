#pragma once

#include <tactile_clay/FocalPointArray.h>

#include "device/array_device.h"

namespace tactile_clay::nodes {

/// The emission that a message asks for. Nothing is judged yet. If the list of weights is neither empty nor
/// complete, the missing weights are NaN, and the gate refuses the field.
device::Emission emissionOf(const FocalPointArray& message);

}  // namespace tactile_clay::nodes
