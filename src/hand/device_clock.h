#pragma once

#include <chrono>
#include <deque>
#include <optional>

namespace tactile_clay::hand {

/// Maps stamps of a device's clock to the receiver's clock. What is received is late by a delay that is never
/// negative, so (receive - device) is the offset of the clocks plus the delay, and its lower envelope is the
/// offset plus the minimum delay. The envelope is the minimum of the last 10 s: the drift of two quartz
/// clocks (100 ppm) is 1 ms in that time.
class DeviceClock {
 public:
  using Time = std::chrono::nanoseconds;

  /// Time of the sample by the receiver's clock; not later than `received`, and later than that of the sample
  /// before. A device that gives no stamp (0) is taken to have sampled when it was received. The envelope
  /// starts anew with a clock that goes back, after a silence of more than 1 s, and where all samples of a
  /// quarter of a second are late by 50 ms: another clock, or a service that was started again.
  Time operator()(Time device, Time received);

  /// How often it was started anew.
  unsigned restarts() const { return restarts_; }

 private:
  struct Offset {
    Time received, offset;
  };
  std::deque<Offset> envelope_;  // candidates for the minimum, offsets increase
  std::optional<Time> late_since_;
  Time last_device_{0}, last_received_{0}, last_result_{Time::min()};
  unsigned restarts_ = 0;
};

}  // namespace tactile_clay::hand
