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

/// Takes the place of a real array: same input, gate and state. Solves the phases of the arrays `~layout` and
/// publishes them with their true field (SoundField).
///
/// With `~wire`, the name of a serial port, it takes the place of the SonicSurface boards behind that port
/// instead. A driver writes the boards' bytes there, and this node publishes the field of the phases that
/// these bytes make the boards play. Gate and `array/state` are then the driver's. The state of the boards is
/// in `array/wire_state` (silent_reason, frames_sent: swaps, frames_rejected: bytes that do not belong to the
/// protocol). `~wire_boards` is 1 or 2, `~wire_firmware` stock or tactile, `~wire_second_board` the pose of
/// the second board.
class SimulatedArray {
 public:
  /// @throws std::runtime_error, std::invalid_argument with one line if a parameter is wrong
  SimulatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  /// The boards behind a serial port.
  struct Wire {
    std::unique_ptr<device::SonicSurfaceTerminal> terminal;
    FocalPointArray::ConstPtr commanded;  // the newest with points
    std::size_t swaps = 0;                // swaps at the last state that was looked at
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
  std::unique_ptr<GatedArray> array_;  // destroyed first: it silences the rest
};

}  // namespace tactile_clay::nodes
