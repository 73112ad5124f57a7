#pragma once

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "device/sonic_surface_protocol.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::device::sonic_surface {

/// The boards that the options `firmware`, `boards` and `board` of the device SonicSurface name.
/// @throws std::runtime_error with one line if such boards do not exist
Boards boardsOf(const std::map<std::string, std::string>& options);

/// Transducers of the boards, in the order of their channels, in the frame of the first board.
/// @param boards 1 or 2
/// @param second pose of the second board in that frame
ultrasound::ArrayLayout layoutOf(std::size_t boards, const Eigen::Isometry3d& second);

/// The array as its boards can play it: phases in steps, channels on or off.
///
/// The boards cannot set an amplitude: for a weaker emission channels are switched off, evenly over the
/// board. The fewer channels are on, the stronger are the side lobes. A weak focal point can be lost in them.
/// Which point is lost depends on the channels that are on. So several patterns of channels are tried: the
/// first one in which all foci are peaks is taken, or else the one with the most peaks. An emission so weak
/// that fewer than four channels would be on is silent, because they make no focus.
///
/// A field is one pattern of all channels. AM swaps it with silence, as it does with focal points. If the
/// field has to be weaker, channels are off in the same way, the same ones in each frame. The phases of the
/// other channels are solved anew.
struct Playable {
  Firmware firmware = Firmware::stock;
  ultrasound::ArrayLayout layout;
  ultrasound::Acoustics acoustics;
  std::vector<double> added;  // turns added to the phase of each channel before it is sent; empty: none

  /// As ArrayDevice::drive.
  /// @throws std::invalid_argument as ultrasound::solvePhases
  ultrasound::Drive drive(const std::vector<ultrasound::FocalPoint>& points) const;

  /// As ArrayDevice::field.
  /// @throws std::invalid_argument as ultrasound::solveField
  ultrasound::FieldSolution field(const std::vector<ultrasound::FocalPoint>& targets,
                                  const ultrasound::FieldSolverOptions& options,
                                  const std::vector<ultrasound::Drive>& before) const;
};

}  // namespace tactile_clay::device::sonic_surface
