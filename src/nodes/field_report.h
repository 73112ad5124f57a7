#pragma once

#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/RenderingReport.h>

#include "device/safety_gate.h"
#include "ultrasound/acoustics.h"

namespace tactile_clay::nodes {

/// Report on a field: the wanted and the given radiation pressure on each skin sample (acoustic_field.h). If
/// there is no field to play, the report has no samples.
/// @param verdict of the gate on `message`, the skin samples
RenderingReport::Ptr fieldReport(const device::Verdict& verdict, const FocalPointArray& message,
                                 const ultrasound::Acoustics& air);

}  // namespace tactile_clay::nodes
