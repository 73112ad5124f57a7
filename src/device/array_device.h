#pragma once

#include <map>
#include <string>
#include <vector>

#include "ultrasound/focal_point.h"

namespace tactile_clay::device {

/// What one update of the array carries.
struct Emission {
  std::vector<ultrasound::FocalPoint> points;  // empty: silence
  double modulation_frequency = 200.0;         // Hz, amplitude modulation
};

/// An ultrasound array behind its own protocol, loaded by pluginlib under this base class. The safety gate
/// stands in front of every device, so a device may trust positions and intensities to be finite and in
/// range.
class ArrayDevice {
 public:
  virtual ~ArrayDevice() = default;

  /// Opens the array.
  /// \param options as given at launch, such as `port`
  /// \throws std::runtime_error with one line: what, where, what was expected
  virtual void open(const std::map<std::string, std::string>& options) = 0;

  /// Sends an emission, newest wins, without waiting for the array.
  /// \throws std::runtime_error when the array is gone
  virtual void submit(const Emission& emission) = 0;

  /// Silences the array, by the surest means that it has. Must not throw.
  virtual void stop() noexcept = 0;

  /// One line for diagnostics; empty while all is well.
  virtual std::string fault() const = 0;
};

}  // namespace tactile_clay::device
