#pragma once

#include <std_msgs/Header.h>
#include <tactile_clay/ArrayDrive.h>

#include <vector>

#include "device/array_device.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// What an array plays of a sound, not modulated down: the drive at the time of the stamp, of a field all its
/// patterns, of silence a silent one.
std::vector<ArrayDrivePtr> driveMessages(const device::Sound& sound, const ultrasound::ArrayLayout& layout,
                                         const std_msgs::Header& header);

}  // namespace tactile_clay::nodes
