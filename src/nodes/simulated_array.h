#pragma once

#include <ros/ros.h>
#include <tactile_clay/FocalPointArray.h>

#include <memory>
#include <vector>

#include "device/sonic_surface_terminal.h"
#include "nodes/array_model.h"
#include "nodes/gated_array.h"
#include "nodes/inbox.h"
#include "nodes/sound_field.h"

namespace tactile_clay::nodes {

/// Stands in for a real array: same input, gate and state. Solves the phases of the arrays `~layout` and
/// publishes them with their true field (SoundField).
///
/// With `~wire`, the name of a serial port, it stands in for the SonicSurface boards behind that port
/// instead: a driver writes the boards' bytes there, and what is published is the field of the phases that
/// these bytes make the boards play. Gate and `array/state` are then the driver's; what the boards do is in
/// `array/wire_state` (silent_reason, frames_sent: swaps, frames_rejected: bytes that are none of the
/// protocol). `~wire_boards` is 1 or 2, `~wire_firmware` stock or tactile, `~wire_second_board` the pose of
/// the second board.
class SimulatedArray {
 public:
  /// @throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  SimulatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  /// Behind a serial port.
  struct Wire {
    std::unique_ptr<device::SonicSurfaceTerminal> terminal;
    FocalPointArray::ConstPtr commanded;  // the newest
    std::size_t swaps = 0;                // told so far
    bool sounds = false;
    ros::Publisher state;
    std::unique_ptr<Inbox> inbox;
    ros::Subscriber focal_points;
    ros::WallTimer timer;
  };

  void startGate(ros::NodeHandle nh, ros::NodeHandle private_nh);
  void startWire(ros::NodeHandle nh, ros::NodeHandle private_nh);
  void listen();

  ArrayModel model_;
  std::unique_ptr<SoundField> field_;
  Wire wire_;
  std::unique_ptr<GatedArray> array_;  // goes first, and silences the rest
};

}  // namespace tactile_clay::nodes
