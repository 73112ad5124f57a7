#pragma once

#include <map>
#include <string>
#include <vector>

namespace tactile_clay::device::sonic_surface {

/// Phase corrections of a board, turns, by channel: what has to be added to the phase that a channel is sent,
/// so that its transducer sounds with the phase that was meant; 0.5 for one that is soldered the other way
/// round.
///
/// A file is a table with the header `channel,turns` and a line for each of the channels 0 to 255, in any
/// order; turns is a number from -1 to 1 or the word `flipped` (half a turn). Lines that begin with # are
/// passed over. Or it is VHDL source of a firmware (`.vhd`): then its constant PHASE_CORRECTION is read, 256
/// numbers in 32nds of a turn.
/// @throws std::runtime_error with one line: file, line, what was expected
std::vector<double> readCorrections(const std::string& path);

/// Turns that are added to the phases of each channel on the way to the wire: what its transducer needs, less
/// what the firmware adds by itself.
/// @param options of the device SonicSurface: `corrections`, `second_corrections`, `firmware_corrections`
/// @param boards how many
/// @return for 256 channels a board; empty: none
/// @throws std::runtime_error as readCorrections, and for corrections of a board that is not there
std::vector<double> addedPhases(const std::map<std::string, std::string>& options, std::size_t boards);

}  // namespace tactile_clay::device::sonic_surface
