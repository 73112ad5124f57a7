#pragma once

#include <ultraleap/haptics/streaming.hpp>

#include <chrono>
#include <memory>
#include <mutex>

#include "device/array_device.h"

namespace tactile_clay::device {

/// Arrays of Ultraleap through the vendor's Haptics SDK 3. The SDK computes the phases: the device takes
/// focal points. Compiled only if CMake finds the SDK.
///
/// Amplitude modulation is the raised cosine (1 - cos(2 pi f t)) / 2, slip vibration is ultrasound::slipWave;
/// both are computed at the sample times of the SDK. Lateral modulation, circles and STM move the control
/// points from instant to instant of their period. The SDK asks for samples in a separate thread. The samples
/// are silent if no emission was submitted for `hold`.
///
/// Options:
/// - `max_points`: number of points to ask the array for, default 8; the array may grant fewer
/// - `hold`: s, default 0.2
/// - `callback_rate`: Hz, how often the SDK asks for samples, default 500: an emission is at most 2 ms late
class Ultraleap : public ArrayDevice {
 public:
  ~Ultraleap() override;

  void requireOptions(const std::map<std::string, std::string>& options) const override;
  void open(const std::map<std::string, std::string>& options) override;
  Capabilities capabilities() const override;
  void submit(const Sound& sound) override;
  void stop() noexcept override;
  std::string fault() const override;

 private:
  static void fill(const ::Ultraleap::Haptics::StreamingEmitter& emitter,
                   ::Ultraleap::Haptics::OutputInterval& interval,
                   const ::Ultraleap::Haptics::LocalTimePoint& deadline, void* self);
  void fill(::Ultraleap::Haptics::OutputInterval& interval);

  std::unique_ptr<::Ultraleap::Haptics::Library> library_;
  std::size_t max_points_ = 0;  // number that the array granted
  std::chrono::duration<double> hold_{0.0};
  bool playing_ = false;

  mutable std::mutex mutex_;  // protects the members below, up to renewed_
  Emission emission_;
  std::vector<std::vector<ultrasound::FocalPoint>> period_;  // points of each instant; none: silence
  double phase_ = 0.0;       // of the modulation, in periods, at the time `played_`
  double slip_phase_ = 0.0;  // of the slip vibration, likewise
  ::Ultraleap::Haptics::LocalTimePoint played_, renewed_;

  std::unique_ptr<::Ultraleap::Haptics::StreamingEmitter> emitter_;  // destroyed first: it calls fill()
};

}  // namespace tactile_clay::device
