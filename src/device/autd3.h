#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>

#include "device/array_device.h"
#include "device/autd3_boards.h"

namespace tactile_clay::device {

/// AUTD3 arrays, one or several boards at any poses, through the AUTD3 library and a server of it on the
/// network. Compiled only where CMake finds the library.
///
/// AM, fields and slip are a buffer of modulation, one second at 4 kHz, so that their frequencies are rounded
/// to whole Hz. What moves (lateral, circles, STM, field_circle) is a list of patterns that the boards take
/// in turn. The newest emission wins: a thread of its own sends it, and silences boards whose emission was
/// not renewed for `hold`. The boards have no watchdog: where this process is killed they play on, which is
/// told at the start.
///
/// Options:
/// - `address` (required): IP:PORT of the server
/// - `boards`: poses of the boards' centres, six numbers each, m and rad; default one at 0 0 0 0 0 0
/// - `temperature` of the air, degrees C, default 20
/// - `hold`: s, default 0.2
class Autd3 : public ArrayDevice {
 public:
  ~Autd3() override;

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
  struct Playing {
    std::vector<ultrasound::Drive> patterns;  // none: silence
    double frequency = 0.0;                   // Hz, of a round of several
    std::vector<std::uint8_t> modulation;
  };

  void run();
  void send(const Playing& wanted);

  std::unique_ptr<Autd3Boards> boards_;
  std::string address_;
  ultrasound::ArrayLayout layout_;
  ultrasound::Acoustics acoustics_;
  Clock::duration hold_{0};
  std::vector<std::uint8_t> modulation_;  // that the boards have; of the thread

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  Playing wanted_;
  Clock::time_point renewed_;
  bool new_ = false, sounds_ = false, ending_ = false;
  std::string fault_ = "not open";

  std::thread thread_;
};

/// A second of modulation as the boards take it: factors 0 to 255 of the amplitude,
/// `Autd3Boards::sample_rate` of them. Empty points: all of it.
std::vector<std::uint8_t> autd3Modulation(const Emission& emission);

}  // namespace tactile_clay::device
