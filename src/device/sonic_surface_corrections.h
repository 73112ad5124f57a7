#pragma once

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
/// numbers in 32nds of a turn. \throws std::runtime_error with one line: file, line, what was expected
std::vector<double> readCorrections(const std::string& path);

}  // namespace tactile_clay::device::sonic_surface
