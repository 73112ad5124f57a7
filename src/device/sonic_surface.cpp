#include "device/sonic_surface.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "safety/silence_times.h"
#include "values/text.h"

namespace tactile_clay::device {
namespace {

using namespace std::chrono_literals;
using sonic_surface::Firmware;
using Clock = std::chrono::steady_clock;

constexpr auto retry = 250ms;           // between tries to open a lost port
constexpr auto open_patience = 1000ms;  // lets the guard of a driver that has just died finish
// Hz. Half a period has to be shorter than the age at which points are stale: new ones are sent between them.
constexpr double slowest_modulation = 20.0;
constexpr std::size_t max_points = 16;  // of a board, at the same time: 16 transducers each

Clock::duration duration(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

SonicSurface::~SonicSurface() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  guard_.reset();  // before the port, because the guard writes its last silence to it
}

void SonicSurface::requireOptions(const std::map<std::string, std::string>& options) const {
  sonic_surface::settingsOf(options);
}

void SonicSurface::open(const std::map<std::string, std::string>& options) {
  if (thread_.joinable()) throw std::runtime_error("sonic_surface: opened a second time");
  settings_ = sonic_surface::settingsOf(options);
  const auto start = Clock::now();
  while (!port_) {
    try {
      connect();
    } catch (const std::exception& error) {
      port_.reset();
      const bool busy = std::string(error.what()).find("in use") != std::string::npos;
      const auto until =
          start +
          (busy ? std::max<std::chrono::duration<double>>(settings_.wait, open_patience) : settings_.wait);
      if (Clock::now() > until)
        throw std::runtime_error(std::string(sonic_surface::self) + ": " + error.what());
      std::this_thread::sleep_for(20ms);
    }
  }
  fault_.clear();
  thread_ = std::thread([this] { run(); });
}

Capabilities SonicSurface::capabilities() const {
  // Bytes of a frame. One byte selects a board of the stock firmware.
  const std::size_t bytes = settings_.boards.count == 2                    ? 517
                            : settings_.boards.firmware == Firmware::stock ? 259
                                                                           : 258;
  // Lateral modulation and STM would need 160 frames per second or more for their steps.
  Capabilities capabilities;
  capabilities.input = Input::drives;
  capabilities.layout = settings_.array.layout;
  capabilities.max_points = settings_.boards.count * max_points;
  capabilities.max_rate = 1.0 / sonic_surface::secondsOnWire(bytes);
  capabilities.modulations = {ultrasound::Modulation::amplitude, ultrasound::Modulation::field};
  capabilities.remarks = settings_.remarks;
  return capabilities;
}

std::optional<ultrasound::Drive> SonicSurface::drive(
    const std::vector<ultrasound::FocalPoint>& points) const {
  return settings_.array.drive(points);
}

std::optional<ultrasound::FieldSolution> SonicSurface::field(
    const std::vector<ultrasound::FocalPoint>& targets, const ultrasound::FieldSolverOptions& options,
    const std::vector<ultrasound::Drive>& before) const {
  return settings_.array.field(targets, options, before);
}

void SonicSurface::submit(const Sound& sound) {
  const Emission& emission = sound.emission;
  if (emission.modulation != ultrasound::Modulation::amplitude &&
      emission.modulation != ultrasound::Modulation::field)
    throw std::runtime_error(std::string(sonic_surface::self) + ": modulation " +
                             ultrasound::nameOf(emission.modulation) +
                             ", expected am or field: the wire is too slow to move points");
  std::optional<Pattern> pattern;
  if (!sound.parts.empty()) {
    Pattern next;
    next.bytes = sonic_surface::frame(sound.parts.front().drive, settings_.boards, settings_.array.added);
    if (settings_.boards.firmware == Firmware::tactile)
      next.bytes.insert(next.bytes.begin(), sonic_surface::modulation(emission.modulation_frequency));
    else if (emission.modulation_frequency > 0.0 && emission.modulation_frequency < slowest_modulation)
      throw std::runtime_error(std::string(sonic_surface::self) + ": modulation of " +
                               values::text(emission.modulation_frequency) + " Hz, expected 0 or at least " +
                               values::text(slowest_modulation) + " Hz");
    else if (emission.modulation_frequency > 0.0)
      next.half_period = duration(0.5 / emission.modulation_frequency);
    pattern = std::move(next);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!fault_.empty()) throw std::runtime_error(fault_);
  wanted_ = std::move(pattern);
  renewed_ = Clock::now();
  changed_.notify_all();
}

void SonicSurface::stop() noexcept {
  const std::lock_guard<std::mutex> lock(mutex_);
  wanted_.reset();
  changed_.notify_all();
}

std::string SonicSurface::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return fault_;
}

void SonicSurface::connect() {
  port_ = std::make_unique<SerialPort>(settings_.path, sonic_surface::baud);
  if (!settings_.guarded && !port_->pseudoTerminal())
    throw std::runtime_error("'" + settings_.path + "': guard is false, expected true on a port of boards");
  if (settings_.guarded)
    guard_ = std::make_unique<SilenceGuard>(port_->descriptor(), sonic_surface::silence(settings_.boards),
                                            silence_times::guard_patience);
  wire_free_ = Clock::now();
  silence();  // the boards may still play something
}

void SonicSurface::run() {
  while (true) {
    try {
      play();
      return;
    } catch (const std::exception& error) {
      const std::lock_guard<std::mutex> lock(mutex_);
      fault_ = std::string(sonic_surface::self) + ": " + error.what() + "; silent until it is back";
      wanted_.reset();
    }
    guard_.reset();
    port_.reset();
    while (!port_) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        if (changed_.wait_for(lock, retry, [this] { return ending_; })) return;
      }
      try {
        connect();
      } catch (const std::exception&) {  // still away, as fault() reports
        guard_.reset();
        port_.reset();
      }
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    fault_.clear();
  }
}

void SonicSurface::write(const std::vector<std::uint8_t>& bytes) {
  port_->write(bytes, silence_times::port_patience);
  wire_free_ = std::max(wire_free_, Clock::now()) + duration(sonic_surface::secondsOnWire(bytes.size()));
}

void SonicSurface::silence() {
  write(sonic_surface::silence(settings_.boards));
  sounding_ = false;
}

/// Silences the boards sooner than a frame of silence alone would.
/// @param silence_behind whether the buffer that does not play is silent
void SonicSurface::hush(bool silence_behind) {
  if (port_->waiting() > 0) {
    port_->drop();  // an upload; without its end it is never played
    wire_free_ = Clock::now();
  } else if (silence_behind) {
    write({sonic_surface::swap_byte});
  }
  silence();
}

/// A guard that is gone or frozen cannot silence the boards any more. So the driver silences them while it
/// still can. A guard that is gone is not started again: whatever ended it may end the next one unnoticed.
/// The mutex is locked.
void SonicSurface::superviseGuard() {
  switch (guard_->beat()) {
    case SilenceGuard::State::there:
      fault_.clear();
      break;
    case SilenceGuard::State::frozen:
      fault_ = std::string(sonic_surface::self) + ": the guard process does not answer; silent until it does";
      break;
    case SilenceGuard::State::gone:
      fault_ = std::string(sonic_surface::self) +
               ": the guard process is gone; silent until the driver is started again";
      break;
  }
}

/// Sends a pattern. It plays as soon as it has arrived completely. The mutex is not locked.
void SonicSurface::upload(const Pattern& pattern, Playing& playing) {
  const bool modulate = pattern.half_period.count() > 0;
  // Modulation needs a silent buffer behind the pattern, as after silence and between modulated patterns.
  if (modulate && !playing.modulated() && sounding_) silence();
  sounding_ = true;
  const auto start = std::max(Clock::now(), wire_free_);
  write(pattern.bytes);
  playing.pattern = pattern;
  playing.heard = true;
  playing.next_swap = wire_free_ + pattern.half_period;
  playing.next_upload = wire_free_;
  while (modulate && playing.next_upload < wire_free_ + (wire_free_ - start))
    playing.next_upload += 2 * pattern.half_period;
}

void SonicSurface::play() {
  Playing playing;
  Clock::time_point last_beat = Clock::now(), checked;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    const auto now = Clock::now();
    if (now - checked > silence_times::guard_beat / 2) {
      checked = now;
      port_->check();
      if (guard_) superviseGuard();
      // The guard may have silenced the boards while this thread believes that they play.
      if (now - last_beat > silence_times::guard_patience / 2) {
        sounding_ = true;
        playing.pattern.reset();
      }
      last_beat = now;
    }
    if (!fault_.empty()) wanted_.reset();
    if (ending_ || (wanted_ && now - renewed_ > settings_.hold)) wanted_.reset();

    if (!wanted_) {
      if (sounding_) {
        lock.unlock();
        hush(playing.modulated() && playing.heard);
        lock.lock();
        playing.pattern.reset();
      } else if (ending_) {
        return;
      } else {
        changed_.wait_for(lock, silence_times::guard_beat, [this] { return wanted_ || ending_; });
      }
      continue;
    }

    const bool modulated = playing.modulated();
    const bool other = !(playing.pattern == wanted_);
    if (other && now >= playing.next_upload && now >= wire_free_ && !(modulated && playing.heard) &&
        port_->waiting() == 0) {
      const Pattern pattern = *wanted_;
      lock.unlock();
      upload(pattern, playing);
      lock.lock();
    } else if (modulated && now >= playing.next_swap) {
      lock.unlock();
      port_->write({sonic_surface::swap_byte}, silence_times::port_patience);
      lock.lock();
      playing.heard = !playing.heard;
      const Clock::duration half = playing.pattern->half_period;
      playing.next_swap = std::max(playing.next_swap, now - half) + half;
    } else {
      // Until the next time to act, an emission that comes only renews the pattern, or waits for that time.
      auto until = now + silence_times::guard_beat / 2;
      if (modulated) until = std::min(until, playing.next_swap);
      if (other) until = std::min(until, std::max({playing.next_upload, wire_free_, now + 500us}));
      changed_.wait_until(lock, until,
                          [&] { return !wanted_ || ending_ || (!other && !(playing.pattern == wanted_)); });
    }
  }
}

}  // namespace tactile_clay::device
