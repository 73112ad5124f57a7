#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/focal_point.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::device {

/// What one update of the array carries.
struct Emission {
  std::vector<ultrasound::FocalPoint> points;  // empty: silence; STM: the path of one focus, in order
  double modulation_frequency = 200.0;         // Hz; 0: amplitude modulation without it, always on
  ultrasound::Modulation modulation = ultrasound::Modulation::amplitude;
};

/// A period of its modulation: the points that have to be there at once, one instant after the other.
std::vector<ultrasound::Instant> period(const Emission& emission);

/// What an open array is and can do.
struct Capabilities {
  ultrasound::ArrayLayout layout;  // its transducers; none: the device does not tell
  std::size_t max_points = 0;      // focal points at a time; 0: any number
  double max_rate = 0.0;           // updates a second that reach the transducers; 0: any number
  std::vector<ultrasound::Modulation> modulations = {
      ultrasound::Modulation::amplitude};  // that submit() can play
};

/// An ultrasound array behind its own protocol, loaded by pluginlib under this base class. The safety gate
/// stands in front of every device, so a device may trust positions and intensities to be finite and in
/// range.
class ArrayDevice {
 public:
  virtual ~ArrayDevice() = default;

  /// Opens the array.
  /// \param options as given at launch, such as `port`; those of other devices are to be passed over
  /// \throws std::runtime_error with one line: what, where, what was expected
  virtual void open(const std::map<std::string, std::string>& options) = 0;

  /// Of the open array.
  virtual Capabilities capabilities() const { return {}; }

  /// The drive that submit() would send for points that are there at once (an instant of the emission's
  /// period), not modulated down, in the channels of the layout: from it the safety gate computes pressures.
  /// Nothing where the array computes its drive itself; the gate then models it.
  virtual std::optional<ultrasound::Drive> drive(const std::vector<ultrasound::FocalPoint>&) const {
    return std::nullopt;
  }

  /// Sends an emission of a modulation that it has named, newest wins, without waiting for the array. It has
  /// to be renewed: a device goes silent by itself when nothing is submitted for some 0.2 s. \throws
  /// std::runtime_error when the array is gone
  virtual void submit(const Emission& emission) = 0;

  /// Silences the array, by the surest means that it has. Must not throw.
  virtual void stop() noexcept = 0;

  /// One line for diagnostics; empty while all is well.
  virtual std::string fault() const = 0;
};

}  // namespace tactile_clay::device
