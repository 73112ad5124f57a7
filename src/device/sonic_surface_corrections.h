#pragma once

#include <map>
#include <string>
#include <vector>

namespace tactile_clay::device::sonic_surface {

/// Reads the phase corrections of a board, in turns, by channel. A correction is added to the phase that a
/// channel is sent, so that its transducer sounds with the intended phase. It is 0.5 for a transducer that is
/// soldered the other way round.
///
/// A file is a table with the header `channel,turns` and one line for each of the channels 0 to 255, in any
/// order; turns is a number from -1 to 1 or the word `flipped` (half a turn). Lines that begin with # are
/// ignored. A file may also be the VHDL source of a firmware (`.vhd`). Then its constant PHASE_CORRECTION is
/// read, 256 numbers in 32nds of a turn.
/// @throws std::runtime_error with one line: file, line, what was expected
std::vector<double> readCorrections(const std::string& path);

/// Turns that are added to the phase of each channel before it is sent: the correction that its transducer
/// needs, minus the correction that the firmware adds by itself.
/// @param options of the device SonicSurface: `corrections`, `second_corrections`, `firmware_corrections`
/// @param boards number of boards
/// @return 256 channels for each board; empty: no corrections
/// @throws std::runtime_error as readCorrections, and for corrections of a board that does not exist
std::vector<double> addedPhases(const std::map<std::string, std::string>& options, std::size_t boards);

}  // namespace tactile_clay::device::sonic_surface
