#pragma once

#include <chrono>

/// All times after which something makes an array silent, in one place; `doc/reference/safety.md` has the
/// same table in words. To get the time until silence, add the time of the last device: a command to
/// SonicSurface boards takes up to one frame of bytes (11.2 ms) on the wire.
namespace tactile_clay::silence_times {

using std::chrono::milliseconds;

/// A time as a number of seconds, for computations.
constexpr double seconds(milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

// Messages to the array.

/// Focal points, and messages of the hands, are stale if they are older than this (default of
/// `~stale_timeout`). Six frames at 60 Hz; a hand at 1 m/s moves 0.1 m in this time.
constexpr milliseconds stale{100};

/// Time between two checks by the gate of the age of the last frame. About one frame at 60 Hz.
constexpr milliseconds watch{20};

/// Stamps that differ by more than this from the clock of the array's host come from another clock. No
/// renderer takes so long, and clocks that NTP keeps in step differ by some ms only.
constexpr milliseconds other_clock{1000};

// The hands.

/// A live tracker that sends no sample for this long is treated as if it saw no hand. A little more than the
/// interval between samples at 60 Hz.
constexpr milliseconds tracker_silent{20};

/// A hand that is not seen stays as it was for this long, because trackers lose hands for one or two samples.
constexpr milliseconds hand_held{30};

/// A hand that was not seen for this long has faded out, and is no longer felt.
constexpr milliseconds hand_gone{80};

/// A live hand that the tracker only repeats counts as not seen. It stays for this long if no hand_cleaner
/// holds and fades it, because some drivers send each sample twice.
constexpr milliseconds hand_repeated{60};

// The device and its guard.

/// A device goes silent by itself if the last emission is not renewed for this long (default of the option
/// `hold`): its node hangs. Longer than `stale`, so that the gate acts first and reports a reason.
constexpr milliseconds device_hold{200};

/// Time between two signs of life of a driver to its guard, and back.
constexpr milliseconds guard_beat{25};

/// A driver or guard that gave no sign of life for this long counts as frozen: the other one silences the
/// boards. With the bytes of silence on the wire this takes less than a quarter of a second. Eight beats,
/// because a busy machine wakes either process late.
constexpr milliseconds guard_patience{200};

/// A port that accepts no byte for this long counts as gone. The wire carries 4.6 kB in that time, more than
/// the buffer of the port contains.
constexpr milliseconds port_patience{200};

/// The same for the guard. It may be longer, because the guard has no other task when its driver is dead.
constexpr milliseconds guard_port_patience{1000};

// Supervisors of the node.

/// Time between an answer of the master and the next question.
constexpr milliseconds supervisor_beat{100};

/// A master, or a roslaunch on another host, that does not answer for this long counts as gone. The array has
/// to be silent within one second, and the gate takes `watch` in addition. A busy machine may need 0.6 s to
/// answer.
constexpr milliseconds supervisor_patience{700};

// The emergency stop.

/// Maximum time from the call of the stop to silence at the device, in 99 of 100 calls, beside two busy
/// loops: the limit of `measure_stop`. The stop has a thread of its own and waits for nothing.
constexpr milliseconds stop{20};

static_assert(hand_held < hand_gone && hand_gone < stale && stale < device_hold);
static_assert(guard_beat * 4 < guard_patience && supervisor_beat * 4 < supervisor_patience);

}  // namespace tactile_clay::silence_times
