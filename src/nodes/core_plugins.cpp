// Plugins that the core rooms implement without knowing of ROS.
#include <pluginlib/class_list_macros.hpp>

#include "device/debug_device.h"
#include "device/sonic_surface.h"
#include "hand/leap_recording.h"
#include "hand/leap_websocket.h"
#ifdef TACTILE_CLAY_AUTD3
#include "device/autd3.h"
#endif
#ifdef TACTILE_CLAY_ULTRALEAP
#include "device/ultraleap.h"
#endif

PLUGINLIB_EXPORT_CLASS(tactile_clay::hand::LeapRecording, tactile_clay::hand::HandSource)
PLUGINLIB_EXPORT_CLASS(tactile_clay::hand::LeapWebsocket, tactile_clay::hand::HandSource)
PLUGINLIB_EXPORT_CLASS(tactile_clay::device::DebugDevice, tactile_clay::device::ArrayDevice)
PLUGINLIB_EXPORT_CLASS(tactile_clay::device::SonicSurface, tactile_clay::device::ArrayDevice)
#ifdef TACTILE_CLAY_ULTRALEAP
PLUGINLIB_EXPORT_CLASS(tactile_clay::device::Ultraleap, tactile_clay::device::ArrayDevice)
#endif
#ifdef TACTILE_CLAY_AUTD3
PLUGINLIB_EXPORT_CLASS(tactile_clay::device::Autd3, tactile_clay::device::ArrayDevice)
#endif
