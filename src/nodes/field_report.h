#pragma once

#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/RenderingReport.h>

#include "device/safety_gate.h"
#include "ultrasound/acoustics.h"

namespace tactile_clay::nodes {

/// Of a field: what is wanted on each sample of skin, and what it is given. Nothing wanted: no samples.
/// @param verdict of the gate on `message`, the samples
RenderingReport::Ptr fieldReport(const device::Verdict& verdict, const FocalPointArray& message,
                                 const ultrasound::Acoustics& air);

}  // namespace tactile_clay::nodes
