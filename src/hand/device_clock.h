#pragma once

#include <chrono>
#include <deque>

namespace tactile_clay::hand {

/// Maps stamps of a device's clock to the receiver's clock. What is received is late by a delay that is never
/// negative, so (receive - device) is the offset of the clocks plus the delay, and its lower envelope is the
/// offset plus the least delay. The envelope is the least of the last 10 s: the drift of two quartz clocks
/// (100 ppm) is 1 ms in that time.
class DeviceClock {
 public:
  using Time = std::chrono::nanoseconds;

  /// Time of the sample by the receiver's clock; not later than `received`, and later than that of the sample
  /// before. A device that gives no stamp (0) is taken to have sampled when it was received. A clock that
  /// goes back, or a silence of more than 1 s, starts the envelope anew: the service was started again.
  Time operator()(Time device, Time received);

  /// How often it was started anew.
  unsigned restarts() const { return restarts_; }

 private:
  struct Offset {
    Time received, offset;
  };
  std::deque<Offset> envelope_;  // candidates for the least, offsets increase
  Time last_device_{0}, last_received_{0}, last_result_{Time::min()};
  unsigned restarts_ = 0;
};

}  // namespace tactile_clay::hand
