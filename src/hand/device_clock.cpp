#include "hand/device_clock.h"

#include <algorithm>

namespace tactile_clay::hand {
namespace {

using namespace std::chrono_literals;

constexpr DeviceClock::Time window = 10s;
constexpr DeviceClock::Time longest_silence = 1s;
constexpr DeviceClock::Time late = 50ms;       // more than any drift
constexpr DeviceClock::Time too_long = 250ms;  // longer than a burst after a stall of the network

}  // namespace

DeviceClock::Time DeviceClock::operator()(Time device, Time received) {
  Time result = received;
  if (device.count() > 0) {
    const Time offset = received - device;
    if (envelope_.empty() || offset - envelope_.front().offset < late)
      late_since_.reset();
    else if (!late_since_)
      late_since_ = received;
    if (!envelope_.empty() && (device <= last_device_ || received - last_received_ > longest_silence ||
                               (late_since_ && received - *late_since_ >= too_long))) {
      envelope_.clear();
      late_since_.reset();
      ++restarts_;
    }
    while (!envelope_.empty() && envelope_.back().offset >= offset) envelope_.pop_back();
    envelope_.push_back({received, offset});
    while (received - envelope_.front().received > window) envelope_.pop_front();
    result = device + envelope_.front().offset;
    last_device_ = device;
    last_received_ = received;
  }
  // If the envelope falls, the offset falls, too. Stamps have to increase all the same.
  if (last_result_ != Time::min()) result = std::max(result, last_result_ + 1us);
  return last_result_ = result;
}

}  // namespace tactile_clay::hand
