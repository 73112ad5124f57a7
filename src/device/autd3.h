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

/// AUTD3 arrays, one or several boards at any poses, through the AUTD3 library and an AUTD3 server on the
/// network. Compiled only if CMake finds the library.
///
/// AM, fields and slip are played from a modulation buffer, one second at 4 kHz, so their frequencies are
/// rounded to whole Hz. Modulations that move (lateral, circles, STM, field_circle) are a list of patterns
/// that the boards play in turn. The newest emission replaces the one before: a separate thread sends it. The
/// thread silences the boards if the emission is not renewed for `hold`. The boards have no watchdog: if this
/// process is killed, they play on. The user is warned of this at the start.
///
/// Options:
/// - `address` (required): IP:PORT of the server
/// - `boards`: poses of the boards' centres, six numbers per board, m and rad; default one at 0 0 0 0 0 0
/// - `temperature` of the air, degrees C, default 20
/// - `hold`: s, default 0.2
class Autd3 : public ArrayDevice {
 public:
  ~Autd3() override;

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
  struct Playing {
    std::vector<ultrasound::Drive> patterns;  // none: silence
    double frequency = 0.0;                   // Hz, of one round through several patterns
    std::vector<std::uint8_t> modulation;
  };

  void run();
  void send(const Playing& wanted);

  struct Settings {
    std::string address;
    std::vector<Eigen::Isometry3d> boards;  // poses of their centres
    ultrasound::ArrayLayout layout;
    ultrasound::Acoustics acoustics;
    std::chrono::duration<double> hold{0.0};
  };
  static Settings settingsOf(const std::map<std::string, std::string>& options);

  Settings settings_;  // set by open()
  std::unique_ptr<Autd3Boards> boards_;
  std::vector<std::uint8_t> modulation_;  // modulation that the boards have; used by the thread only

  mutable std::mutex mutex_;  // protects the members below, up to fault_
  std::condition_variable changed_;
  Playing wanted_;
  Clock::time_point renewed_;
  bool new_ = false, sounds_ = false, ending_ = false;
  std::string fault_ = "not open";

  std::thread thread_;
};

/// One second of modulation in the form that the boards take: `Autd3Boards::sample_rate` factors of the
/// amplitude, 0 to 255.
std::vector<std::uint8_t> autd3Modulation(const Emission& emission);

}  // namespace tactile_clay::device
