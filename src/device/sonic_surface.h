#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>

#include "device/array_device.h"
#include "device/serial_port.h"
#include "device/silence_guard.h"
#include "device/sonic_surface_settings.h"

namespace tactile_clay::device {

/// The SonicSurface open array: one or two boards of 16 x 16 transducers on a serial port.
///
/// The newest emission replaces the one before: a separate thread writes frames no faster than the wire takes
/// them (89 per second, 44 with two boards) and never queues one behind another. To modulate with the stock
/// firmware, one buffer of the boards is silent, and the buffers are swapped every half period. A new frame
/// is uploaded while the silent buffer plays. It is then modulated for at least as long as the upload took.
///
/// sonic_surface::Playable describes which focal points and fields the boards can play.
///
/// The boards fall silent on stop(), at the end, and if no emission renews the last one for `hold`. If this
/// process dies or hangs, a guard process silences them. The bytes of silence (sonic_surface::silence) work
/// in whatever state a program before has left the boards. After them, programs that know only one board find
/// it. A port that goes away is opened again as soon as it is back.
///
/// Options:
/// - `port` (required), such as /dev/serial/by-id/...
/// - `firmware`: `stock` (default) or `tactile`
/// - `boards`: 1 (default) or 2 (stock firmware)
/// - `board`: `primary` (default) or `secondary`, the stock firmware of a single board
/// - `corrections`, `second_corrections`: file with the phase corrections of the first and the second board
///   (readCorrections)
/// - `firmware_corrections`: file with the corrections that the firmware adds by itself, which are
///   subtracted; `none`: it adds none
/// - `second_board`: pose "x y z roll pitch yaw" of the second board in the frame of the first (m, rad);
///   default beside it, at x = 0.168
/// - `temperature` of the air, degrees C, default 20
/// - `hold`: s, default 0.2
/// - `wait`: s to wait for a port that is not there yet, default 0
/// - `guard`: `true` (default); `false` only for tests, on a pseudo-terminal
class SonicSurface : public ArrayDevice {
 public:
  SonicSurface() = default;
  ~SonicSurface() override;

  void requireOptions(const std::map<std::string, std::string>& options) const override;
  void open(const std::map<std::string, std::string>& options) override;
  Capabilities capabilities() const override;
  std::optional<ultrasound::Drive> drive(const std::vector<ultrasound::FocalPoint>& points) const override;
  std::optional<ultrasound::FieldSolution> field(const std::vector<ultrasound::FocalPoint>& targets,
                                                 const ultrasound::FieldSolverOptions& options,
                                                 const std::vector<ultrasound::Drive>& before) const override;
  void submit(const Sound& sound) override;
  void stop() noexcept override;
  std::string fault() const override;

 private:
  using Clock = std::chrono::steady_clock;

  struct Pattern {
    std::vector<std::uint8_t> bytes;  // to upload, with the swap at the end
    Clock::duration half_period{0};   // of the modulation by swapping; 0: none
    bool operator==(const Pattern& other) const {
      return bytes == other.bytes && half_period == other.half_period;
    }
  };

  /// What the boards play, as the thread knows it.
  struct Playing {
    std::optional<Pattern> pattern;  // none: the boards are silent
    bool heard = false;              // whether the pattern plays, not the silent buffer
    Clock::time_point next_swap, next_upload;
    bool modulated() const { return pattern && pattern->half_period.count() > 0; }
  };

  void connect();
  void run();
  void superviseGuard();
  void play();
  void upload(const Pattern& pattern, Playing& playing);
  void write(const std::vector<std::uint8_t>& bytes);
  void silence();
  void hush(bool silence_behind);

  sonic_surface::Settings settings_;  // set by open()

  // Used by the thread only.
  std::unique_ptr<SerialPort> port_;
  std::unique_ptr<SilenceGuard> guard_;
  Clock::time_point wire_free_;  // when the last frame has left the wire
  bool sounding_ = false;        // whether a buffer may have sound in it

  mutable std::mutex mutex_;  // protects the members below, up to ending_
  std::condition_variable changed_;
  std::optional<Pattern> wanted_;  // none: silence
  Clock::time_point renewed_;
  std::string fault_ = "not open";
  bool ending_ = false;

  std::thread thread_;
};

}  // namespace tactile_clay::device
