#include "hand/device_clock.h"

#include <algorithm>

namespace tactile_clay::hand {
namespace {

using namespace std::chrono_literals;

constexpr DeviceClock::Time window = 10s;
constexpr DeviceClock::Time longest_silence = 1s;
constexpr DeviceClock::Time latest_sample = 1s;  // older than this, it is another clock

}  // namespace

DeviceClock::Time DeviceClock::operator()(Time device, Time received) {
  Time result = received;
  if (device.count() > 0) {
    const Time offset = received - device;
    if (!envelope_.empty() && (device <= last_device_ || received - last_received_ > longest_silence ||
                               offset - envelope_.front().offset > latest_sample)) {
      envelope_.clear();
      ++restarts_;
    }
    while (!envelope_.empty() && envelope_.back().offset >= offset) envelope_.pop_back();
    envelope_.push_back({received, offset});
    while (received - envelope_.front().received > window) envelope_.pop_front();
    result = device + envelope_.front().offset;
    last_device_ = device;
    last_received_ = received;
  }
  // A lower envelope moves the offset down: the stamp still goes on.
  if (last_result_ != Time::min()) result = std::max(result, last_result_ + 1us);
  return last_result_ = result;
}

}  // namespace tactile_clay::hand
