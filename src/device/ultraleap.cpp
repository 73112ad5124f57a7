#include "device/ultraleap.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "device/options.h"
#include "ultrasound/slip.h"

namespace tactile_clay::device {
namespace {

namespace sdk = ::Ultraleap::Haptics;

/// @throws std::runtime_error with one line if the SDK call failed
template <class Result>
void require(const Result& result, const std::string& what, const std::string& expected) {
  if (!result)
    throw std::runtime_error("ultraleap: " + what + ": " + result.error().message() + "; expected " +
                             expected);
}

struct Settings {
  std::size_t max_points = 0;
  std::chrono::duration<double> hold{0.0};
  double callback_rate = 0.0;  // Hz
};

/// @throws std::runtime_error with one line if an option is wrong
Settings settingsOf(const std::map<std::string, std::string>& options) {
  constexpr char self[] = "ultraleap";
  Settings settings;
  settings.max_points = static_cast<std::size_t>(number(options, self, "max_points", 8, 1, 64));
  settings.hold = holdOf(options, self);
  settings.callback_rate = number(options, self, "callback_rate", 500.0, 50.0, 2000.0);
  return settings;
}

}  // namespace

Ultraleap::~Ultraleap() {
  if (emitter_) (void)emitter_->stop();
}

void Ultraleap::requireOptions(const std::map<std::string, std::string>& options) const {
  settingsOf(options);
}

void Ultraleap::open(const std::map<std::string, std::string>& options) {
  const auto [wanted, hold, callback_rate] = settingsOf(options);
  hold_ = hold;
  library_ = std::make_unique<sdk::Library>();
  require(library_->connect(), "the haptics service cannot be reached", "a running service");
  const auto array = library_->findDevice(sdk::DeviceFeatures::StreamingHaptics);
  require(array, "no array", "one that streams, connected");
  emitter_ = std::make_unique<sdk::StreamingEmitter>(*library_);
  require(emitter_->addDevice(array.value()), "the array cannot be used", "one that no other program uses");
  // The array decides how many points it can play: the highest number that it accepts, up to the wanted one.
  std::size_t count = wanted;
  while (count > 1 && !emitter_->setControlPointCount(count, sdk::AdjustRate::All)) --count;
  require(emitter_->setControlPointCount(count, sdk::AdjustRate::All), "no control points", "at least 1");
  const auto granted = emitter_->getControlPointCount();
  require(granted, "number of control points", "a number");
  max_points_ = std::min(count, static_cast<std::size_t>(granted.value()));
  played_ = renewed_ = sdk::LocalTimeClock::now();
  require(emitter_->setEmissionCallback(&Ultraleap::fill, this), "no callback", "one");
  require(emitter_->setCallbackRate(static_cast<float>(callback_rate)),
          "callback_rate is " + std::to_string(callback_rate), "a rate that the array can do");
  require(emitter_->start(), "the array does not start", "a start");
  require(emitter_->pause(), "the array does not pause", "a pause");
}

Capabilities Ultraleap::capabilities() const {
  Capabilities capabilities;
  capabilities.max_points = max_points_;
  using ultrasound::Modulation;
  capabilities.modulations = {Modulation::amplitude, Modulation::lateral, Modulation::spatiotemporal,
                              Modulation::circle};
  capabilities.slip = true;
  return capabilities;
}

void Ultraleap::submit(const Sound& sound) {
  const Emission& emission = sound.emission;
  if (!emitter_) throw std::runtime_error("ultraleap: emission before it was opened");
  std::vector<std::vector<ultrasound::FocalPoint>> played;
  for (const Sound::Part* part : instants(sound)) {
    played.push_back(part->what.points);
    if (played.back().size() > max_points_)
      throw std::runtime_error("ultraleap: " + std::to_string(played.back().size()) +
                               " focal points at a time, expected at most " + std::to_string(max_points_));
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    emission_ = emission;
    period_ = std::move(played);
    renewed_ = sdk::LocalTimeClock::now();
  }
  if (sound.parts.empty()) {
    stop();
  } else if (!playing_) {
    require(emitter_->resume(), "the array does not go on", "an array");
    playing_ = true;
  }
}

void Ultraleap::stop() noexcept {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    period_.clear();
  }
  playing_ = false;
  try {
    if (emitter_) (void)emitter_->pause();
  } catch (...) {
    // The callback gives silent samples already.
  }
}

std::string Ultraleap::fault() const {
  return emitter_ ? "" : "not open";
}

void Ultraleap::fill(const sdk::StreamingEmitter&, sdk::OutputInterval& interval, const sdk::LocalTimePoint&,
                     void* self) {
  static_cast<Ultraleap*>(self)->fill(interval);
}

void Ultraleap::fill(sdk::OutputInterval& interval) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto& sample : interval) {
    const sdk::LocalTimePoint& at = sample;
    const bool held = at - renewed_ > hold_;
    // The phases go on from the last sample, so that a new frequency does not make the modulation jump.
    const double passed = std::chrono::duration<double>(at - played_).count();
    phase_ += emission_.modulation_frequency * passed;
    phase_ -= std::floor(phase_);
    slip_phase_ += ultrasound::slip_low * passed;
    slip_phase_ -= std::floor(slip_phase_);
    played_ = at;
    const double modulated =
        emission_.modulation == ultrasound::Modulation::amplitude && emission_.modulation_frequency > 0.0
            ? 0.5 - 0.5 * std::cos(2.0 * M_PI * phase_)
            : 1.0;
    const double wave = ultrasound::slipWave(slip_phase_ / ultrasound::slip_low);
    const double envelope = (1.0 - emission_.slip) * modulated + emission_.slip * wave;
    const auto now = std::min(static_cast<std::size_t>(phase_ * static_cast<double>(period_.size())),
                              std::max<std::size_t>(period_.size(), 1) - 1);
    const std::size_t count = held || period_.empty() ? 0 : period_[now].size();
    for (std::size_t i = 0; i < max_points_; ++i) {
      auto&& control_point = sample.controlPoint(i);
      if (i >= count) {
        control_point.setIntensity(0.0f);
        continue;
      }
      const ultrasound::FocalPoint& point = period_[now][i];
      const Eigen::Vector3f position = point.position.cast<float>();
      sdk::Vector3 where;
      where.x = position.x();
      where.y = position.y();
      where.z = position.z();
      control_point.setPosition(where);
      control_point.setIntensity(static_cast<float>(point.intensity * envelope));
    }
  }
}

}  // namespace tactile_clay::device
