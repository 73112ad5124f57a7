#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/focal_point.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::device {

/// A request to the array, before the safety gate judges it.
struct Emission {
  /// Focal points; none: silence. With STM: the path of one focus, in order. With a field: skin samples;
  /// those where nothing is to be felt have intensity 0.
  std::vector<ultrasound::FocalPoint> points;
  double modulation_frequency = 200.0;  // Hz; 0 (only with `amplitude`): points are on all the time
  ultrasound::Modulation modulation = ultrasound::Modulation::amplitude;
  double slip = 0.0;  // 0-1, share of the pressure that vibrates as sliding clay does (ultrasound::slipWave)
};

/// One period of the modulation, in instants: the points that sound at the same time at each instant. If a
/// part of the pressure vibrates because of slip, the amplitudes are root mean squares over this vibration.
std::vector<ultrasound::Instant> period(const Emission& emission);

/// What may sound: the safety gate makes it from an emission, and a device plays exactly this.
struct Sound {
  /// Points that sound at the same time, and the drive that was judged for them.
  struct Part {
    ultrasound::Part what;
    ultrasound::Drive drive;  // all transducers, at full amplitude: without the envelope of the modulation
    /// Amplitude that the phase solver was asked for at each of the points, Pa; empty: not known. In a field
    /// each part is one pattern, and this is the wanted root mean square over all patterns.
    std::vector<double> target;
  };
  Emission emission;        // as it was asked for, but its points may be weaker
  std::vector<Part> parts;  // of one period of the modulation; none: silence
};

/// The parts of a sound in the order in which they are played: one for each instant of the period.
std::vector<const Sound::Part*> instants(const Sound& sound);

/// What a device plays of a Sound.
enum class Input {
  points,  // focal points of the parts: the array computes the phases, the gate models the array
  drives   // drives of the parts
};

/// What an open array is and can do.
struct Capabilities {
  Input input = Input::points;
  ultrasound::ArrayLayout layout;  // its transducers; devices that take points may leave it out
  std::size_t max_points = 0;      // focal points that sound at the same time; 0: any number
  double max_rate = 0.0;           // updates per second that reach the transducers; 0: any number
  std::vector<ultrasound::Modulation> modulations = {
      ultrasound::Modulation::amplitude};  // those that submit() can play
  bool slip = false;                       // whether the device plays Emission::slip, too
  /// Lines that the user should read, for example about an option that may be missing.
  std::vector<std::string> remarks;
};

/// An ultrasound array behind its own protocol, loaded by pluginlib under this base class. The safety gate
/// stands in front of every device and has judged each Sound. So a device plays the Sound and nothing else,
/// and solves nothing anew. It may rely on finite positions and intensities within their ranges.
class ArrayDevice {
 public:
  virtual ~ArrayDevice() = default;

  /// Whether nobody can be hurt, because there is no array behind the device. Only then may rules of the gate
  /// be left out. Called before open().
  virtual bool harmless() const { return false; }

  /// Checks the options without opening the array. Called before anything starts.
  /// @throws std::runtime_error as open()
  virtual void requireOptions(const std::map<std::string, std::string>&) const {}

  /// Opens the array.
  /// @param options as given at launch, such as `port`. Options of other devices are ignored. `temperature`
  /// of the air (degrees C) is always among them; the gate uses the same value
  /// @throws std::runtime_error with one line: what, where, what was expected
  virtual void open(const std::map<std::string, std::string>& options) = 0;

  /// Capabilities of the open array.
  virtual Capabilities capabilities() const { return {}; }

  /// For arrays that take drives but cannot play every drive: the drive for points that sound at the same
  /// time (an instant of the emission's period), at full amplitude, without the envelope of the modulation.
  /// The array can play this drive exactly: phases are rounded, channels are on or off. The gate judges it,
  /// asks for another one if it is too loud, and passes the accepted one to submit().
  /// @return nothing: the gate solves the phases for the layout itself
  virtual std::optional<ultrasound::Drive> drive(const std::vector<ultrasound::FocalPoint>&) const {
    return std::nullopt;
  }

  /// The same for fields, for arrays that can play Modulation::field or field_circle: the patterns for skin
  /// samples, and the amplitudes that they reach there.
  /// @param options of the solver; `amplitude` is the maximum that each transducer may use
  /// @param before patterns of the frame before, or none
  /// @return nothing: the gate solves the field for the layout itself
  virtual std::optional<ultrasound::FieldSolution> field(
      [[maybe_unused]] const std::vector<ultrasound::FocalPoint>& targets,
      [[maybe_unused]] const ultrasound::FieldSolverOptions& options,
      [[maybe_unused]] const std::vector<ultrasound::Drive>& before) const {
    return std::nullopt;
  }

  /// Sends what the gate returned, without waiting for the array. The modulation is one of capabilities(),
  /// and the newest sound replaces the one before. A sound has to be renewed: the device goes silent by
  /// itself if nothing is submitted for about 0.2 s.
  /// @throws std::runtime_error if the array is gone
  virtual void submit(const Sound& sound) = 0;

  /// Silences the array in the surest way that it has. Must not throw.
  virtual void stop() noexcept = 0;

  /// One line for diagnostics; empty while all is well.
  virtual std::string fault() const = 0;
};

}  // namespace tactile_clay::device
