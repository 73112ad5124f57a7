#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::device {

/// AUTD3 boards through the functions of the AUTD3 library (autd3capi). Each call talks to the boards and
/// waits for them, some ms; all calls come from one thread.
class Autd3Boards {
 public:
  static constexpr int phase_levels = 256;       // of a turn
  static constexpr int amplitude_levels = 255;   // of the amplitude, above 0
  static constexpr double sample_rate = 4000.0;  // Hz, of the modulation
  static constexpr std::size_t max_patterns = 1024;

  /// Transducers of boards at these poses, in the order of the library: board after board, 249 each.
  static ultrasound::ArrayLayout layoutOf(const std::vector<Eigen::Isometry3d>& boards);

  /// @param address of the AUTD3 server on the network, IP:PORT
  /// @param boards pose of the centre of each
  /// @throws std::runtime_error with one line where it is not there, or has its transducers elsewhere
  Autd3Boards(const std::string& address, const std::vector<Eigen::Isometry3d>& boards);
  ~Autd3Boards();
  Autd3Boards(const Autd3Boards&) = delete;
  Autd3Boards& operator=(const Autd3Boards&) = delete;

  /// Factors 0 to 255 of all amplitudes, `sample_rate` a second, over and over.
  /// @throws as above
  void modulate(const std::vector<std::uint8_t>& samples);

  /// Drives one after the other, over and over; phases and amplitudes that are no levels are rounded,
  /// amplitudes down.
  /// @param patterns at least one, of `layoutOf`'s length
  /// @param frequency Hz, of a round of several
  /// @throws as above
  void play(const std::vector<ultrasound::Drive>& patterns, double frequency);

  /// @throws as above
  void silence();

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace tactile_clay::device
