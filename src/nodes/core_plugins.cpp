// Plugins that the core rooms implement without knowing of ROS.
#include <pluginlib/class_list_macros.hpp>

#include "device/debug_device.h"
#include "hand/leap_recording.h"
#include "hand/leap_websocket.h"

PLUGINLIB_EXPORT_CLASS(tactile_clay::hand::LeapRecording, tactile_clay::hand::HandSource)
PLUGINLIB_EXPORT_CLASS(tactile_clay::hand::LeapWebsocket, tactile_clay::hand::HandSource)
PLUGINLIB_EXPORT_CLASS(tactile_clay::device::DebugDevice, tactile_clay::device::ArrayDevice)
