#pragma once

// Stands in for the header of the vendor's Haptics SDK 3, which cannot be shipped: the names that our device
// uses, as the SDK's public documentation gives them, over an array that exists only in the test. The real
// SDK calls the emission callback in a thread of its own; here the test calls it by StandIn::stream.

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace Ultraleap::Haptics {

using LocalTimeClock = std::chrono::steady_clock;
using LocalTimePoint = LocalTimeClock::time_point;

struct Error {
  std::string text;
  std::string message() const { return text; }
};

template <class T>
class result {
 public:
  result(T value) : value_(value), good_(true) {}
  result(Error error) : error_(error) {}
  explicit operator bool() const { return good_; }
  const T& value() const { return value_; }
  const Error& error() const { return error_; }

 private:
  T value_{};
  Error error_;
  bool good_ = false;
};

template <>
class result<void> {
 public:
  result() = default;
  result(Error error) : error_(error), good_(false) {}
  explicit operator bool() const { return good_; }
  const Error& error() const { return error_; }

 private:
  Error error_;
  bool good_ = true;
};

struct Vector3 {
  float x = 0.0f, y = 0.0f, z = 0.0f;
};

class ControlPoint {
 public:
  void setPosition(const Vector3& position) { position_ = position; }
  void setIntensity(float intensity) { intensity_ = intensity; }
  Vector3 position_;
  float intensity_ = -1.0f;  // never set
};

class TimePointOnOutputInterval : public LocalTimePoint {
 public:
  TimePointOnOutputInterval(LocalTimePoint time, std::size_t points)
      : LocalTimePoint(time), points_(points) {}
  ControlPoint& controlPoint(std::size_t i) { return points_.at(i); }
  std::vector<ControlPoint> points_;
};

using OutputInterval = std::vector<TimePointOnOutputInterval>;

enum class DeviceFeatures { StreamingHaptics };
enum class AdjustRate { All, AsRequired, None };

class Device {};
class StreamingEmitter;
using EmissionCallback = void (*)(const StreamingEmitter&, OutputInterval&, const LocalTimePoint&, void*);

/// The array of the test.
struct StandIn {
  bool service = true, connected = true;
  std::size_t max_points = 4;
  float max_callbacks = 1000.0f;  // a second

  const StreamingEmitter* emitter = nullptr;
  std::size_t points = 0;
  EmissionCallback callback = nullptr;
  void* data = nullptr;
  float callback_rate = 0.0f;  // Hz; 0: never set
  bool started = false, paused = false;

  /// What the array is given over an interval. Silent while it is paused or not started.
  OutputInterval stream(LocalTimePoint from, std::chrono::microseconds step, std::size_t samples) {
    OutputInterval interval;
    if (!started || paused) return interval;
    for (std::size_t i = 0; i < samples; ++i) interval.emplace_back(from + i * step, points);
    callback(*emitter, interval, from, data);
    return interval;
  }
};

inline StandIn& standIn() {
  static StandIn array;
  return array;
}

class Library {
 public:
  result<void> connect() { return standIn().service ? result<void>() : Error{"no service"}; }
  result<Device> findDevice(DeviceFeatures) {
    return standIn().connected ? result<Device>(Device()) : result<Device>(Error{"no device"});
  }
};

class StreamingEmitter {
 public:
  explicit StreamingEmitter(Library&) { standIn().emitter = this; }
  ~StreamingEmitter() { standIn().emitter = nullptr; }
  result<void> addDevice(const Device&) { return {}; }
  result<void> setControlPointCount(std::size_t count, AdjustRate) {
    if (count > standIn().max_points) return Error{"too many control points"};
    standIn().points = count;
    return {};
  }
  result<std::size_t> getControlPointCount() const { return standIn().points; }
  result<void> setEmissionCallback(EmissionCallback callback, void* data) {
    standIn().callback = callback;
    standIn().data = data;
    return {};
  }
  result<void> setCallbackRate(float rate) {
    if (standIn().started) return Error{"already started"};
    if (!(rate > 0.0f && rate <= standIn().max_callbacks)) return Error{"callback rate out of range"};
    standIn().callback_rate = rate;
    return {};
  }
  result<void> start() { return standIn().started = true, result<void>(); }
  result<void> pause() { return standIn().paused = true, result<void>(); }
  result<void> resume() { return standIn().paused = false, result<void>(); }
  result<void> stop() { return standIn().started = false, result<void>(); }
};

}  // namespace Ultraleap::Haptics
