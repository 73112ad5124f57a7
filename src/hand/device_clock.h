#pragma once

#include <chrono>
#include <deque>
#include <optional>

namespace tactile_clay::hand {

/// Converts stamps of a device's clock to the receiver's clock. A sample arrives late by a delay that is
/// never negative. So (receive - device) is the offset of the clocks plus the delay, and its lower envelope
/// is the offset plus the minimum delay. The envelope is the minimum of the last 10 s: in that time the drift
/// of two quartz clocks (100 ppm) is 1 ms.
class DeviceClock {
 public:
  using Time = std::chrono::nanoseconds;

  /// Time of the sample by the receiver's clock: not later than `received`, and later than the sample before.
  /// If a device gives no stamp (0), the time of reception counts. The envelope starts anew if the device's
  /// clock goes back, after a silence of more than 1 s, and if all samples of a quarter of a second are late
  /// by 50 ms: then it is another clock, or the service was started again.
  Time operator()(Time device, Time received);

  /// How often the envelope was started anew.
  unsigned restarts() const { return restarts_; }

 private:
  struct Offset {
    Time received, offset;
  };
  std::deque<Offset> envelope_;  // candidates for the minimum, by increasing offset
  std::optional<Time> late_since_;
  Time last_device_{0}, last_received_{0}, last_result_{Time::min()};
  unsigned restarts_ = 0;
};

}  // namespace tactile_clay::hand
