#pragma once

#include <chrono>

/// All times after which something makes an array silent, in one place; `doc/reference/safety.md` has the
/// same table in words. Whoever waits for silence adds what the last of the chain takes: SonicSurface boards
/// are silent one frame (11.2 ms) after they are told.
namespace tactile_clay::silence_times {

using std::chrono::milliseconds;

/// s of a time, where numbers are reckoned with.
constexpr double seconds(milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

// What is sent to the array.

/// Focal points, and word of the hands, older than this are stale (default of `~stale_timeout`). Six frames
/// at 60 Hz; a hand at 1 m/s has moved by 0.1 m.
constexpr milliseconds stale{100};

/// Between two looks of the gate at how old the last frame is. A frame of 60 Hz.
constexpr milliseconds watch{20};

/// Stamps that are farther than this from the clock of the array's host are of another clock: no renderer
/// takes so long, and clocks that are kept in step by NTP are within some ms of each other.
constexpr milliseconds other_clock{1000};

// The hands.

/// A live tracker that sends no sample for this long is taken for one that sees no hand. A sample at 60 Hz
/// and a bit.
constexpr milliseconds tracker_silent{20};

/// A hand that is not seen stays as it was for this long: trackers lose hands for a sample or two.
constexpr milliseconds hand_held{30};

/// It has faded out when it was not seen for this long, and is felt no more.
constexpr milliseconds hand_gone{80};

/// A live hand that is only repeated was not seen. It stays for this long where nobody holds and fades hands,
/// for some drivers send each sample twice.
constexpr milliseconds hand_repeated{60};

// The device and its guard.

/// A device goes silent by itself when nothing renews the last emission for this long (default of the option
/// `hold`): its node hangs. Longer than `stale`, for the gate comes first and has a reason to tell.
constexpr milliseconds device_hold{200};

/// Between two signs of life of a driver to its guard, and back.
constexpr milliseconds guard_beat{25};

/// Driver or guard that gave no sign for this long is frozen: the other one silences the boards. With the
/// frame of silence on the wire less than a quarter of a second. Eight beats, for a busy machine wakes
/// either one late.
constexpr milliseconds guard_patience{200};

/// A port that takes no byte for this long is gone. The wire takes 4.6 kB in that time, more than its buffer.
constexpr milliseconds port_patience{200};

/// The same for the guard, which has nothing to hurry for when its driver is dead.
constexpr milliseconds guard_port_patience{1000};

// Whoever supervises the node.

/// Between an answer of the master and the next question.
constexpr milliseconds supervisor_beat{100};

/// A master, or a roslaunch on another host, that does not answer for this long is gone. The array is to be
/// silent within a second, the gate takes `watch` more; and a busy machine may take 0.6 s to answer.
constexpr milliseconds supervisor_patience{700};

// The emergency stop.

/// At most, of 99 of 100 calls, from the call to silence at the device, beside two busy loops: what
/// `measure_stop` asks for. The stop has a thread of its own and waits for nothing.
constexpr milliseconds stop{20};

static_assert(hand_held < hand_gone && hand_gone < stale && stale < device_hold);
static_assert(guard_beat * 4 < guard_patience && supervisor_beat * 4 < supervisor_patience);

}  // namespace tactile_clay::silence_times
