#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

#include "device/array_device.h"

namespace tactile_clay::device {

/// An array that does not exist: logs what it would emit, one line per emission, at most `log_rate` lines per
/// second. It counts each emission and each stop, whether a line was logged or not.
///
/// Options: `log_rate` in Hz (default 1; 0 logs only open and stop). Options of other devices are ignored.
class DebugDevice : public ArrayDevice {
 public:
  using Sink = std::function<void(const std::string&)>;  // takes one line, without its end
  using Clock = std::function<std::chrono::nanoseconds()>;

  /// Logs to stderr.
  DebugDevice();

  /// @param sink gets the lines
  /// @param clock for the rate of the lines, monotonic
  DebugDevice(Sink sink, Clock clock);

  bool harmless() const override { return true; }
  void requireOptions(const std::map<std::string, std::string>& options) const override;
  void open(const std::map<std::string, std::string>& options) override;
  Capabilities capabilities() const override;  // every modulation
  void submit(const Sound& sound) override;
  void stop() noexcept override;
  std::string fault() const override;

  std::uint64_t submissions() const { return submissions_; }
  std::uint64_t stops() const { return stops_; }
  bool emitting() const { return emitting_; }

 private:
  Sink sink_;
  Clock clock_;
  std::chrono::nanoseconds interval_{0};
  std::chrono::nanoseconds last_line_{0};
  bool open_ = false;
  bool quiet_ = false;     // log_rate is 0
  bool said_any_ = false;  // whether an emission was logged since open()
  bool emitting_ = false;
  std::uint64_t submissions_ = 0;
  std::uint64_t stops_ = 0;
};

}  // namespace tactile_clay::device
