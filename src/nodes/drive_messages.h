#pragma once

#include <std_msgs/Header.h>
#include <tactile_clay/ArrayDrive.h>

#include <vector>

#include "device/array_device.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// The drives that an array plays for a sound, without the envelope of the modulation: one drive, the one at
/// the time of the stamp. For a field: all its patterns. For silence: one drive of amplitude 0.
std::vector<ArrayDrivePtr> driveMessages(const device::Sound& sound, const ultrasound::ArrayLayout& layout,
                                         const std_msgs::Header& header);

}  // namespace tactile_clay::nodes
