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
/// @throws std::runtime_error with one line where there are no such boards
Boards boardsOf(const std::map<std::string, std::string>& options);

/// Transducers of the boards, in the order of their channels, in the frame of the first board.
/// @param boards 1 or 2
/// @param second pose of the second board in that frame
ultrasound::ArrayLayout layoutOf(std::size_t boards, const Eigen::Isometry3d& second);

/// The array as its boards can play it: phases in steps, channels on or off.
///
/// The boards know no amplitude: a weaker emission switches channels off, evenly over the board. The fewer
/// are on, the stronger are the side lobes, in which a weak focal point can be lost; which one it is differs
/// with the channels, so of some patterns of them the first is taken in which all foci are peaks, or the
/// one with the most. Emissions so weak that fewer than four channels were on are silent: they have no focus.
///
/// A field is one pattern of all channels, which AM swaps with silence as it does focal points. Where it has
/// to be weaker, channels are off in the same way, the same ones in each frame, and the others are solved
/// anew.
struct Playable {
  Firmware firmware = Firmware::stock;
  ultrasound::ArrayLayout layout;
  ultrasound::Acoustics acoustics;
  std::vector<double> added;  // turns, to the phases of each channel on the way to the wire; empty: none

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
