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

/// What is asked of the array.
struct Emission {
  /// Empty: silence; STM: the path of one focus, in order; field: samples of skin, of intensity 0 where
  /// nothing is to be felt
  std::vector<ultrasound::FocalPoint> points;
  double modulation_frequency = 200.0;  // Hz; 0: amplitude modulation without it, always on
  ultrasound::Modulation modulation = ultrasound::Modulation::amplitude;
  double slip = 0.0;  // 0-1, share of the pressure that vibrates as sliding clay does (ultrasound::slipWave)
};

/// A period of its modulation: the points that have to be there at once, one instant after the other. Where
/// some of it vibrates of slip, amplitudes are root mean squares over that.
std::vector<ultrasound::Instant> period(const Emission& emission);

/// What may sound: what the safety gate makes of an emission, and what a device plays exactly.
struct Sound {
  /// Points that are there at once, and the drive that was judged for them.
  struct Part {
    ultrasound::Part what;
    ultrasound::Drive drive;  // of each transducer of the layout, while the part is there at full amplitude
    std::vector<double> target;  // Pa at each of its points, as the phase solver was asked; empty: not known
                                 // (of a field: wanted of the mean over its patterns, a part each)
  };
  Emission emission;        // as asked for, its points perhaps weaker
  std::vector<Part> parts;  // of a period of its modulation; none: silence
};

/// The parts of a sound in the order in which they are played, one an instant of its period.
std::vector<const Sound::Part*> instants(const Sound& sound);

/// What a device plays of a Sound.
enum class Input {
  points,  // the focal points of its parts: the array computes phases itself, and the gate models them
  drives   // the drive of each part
};

/// What an open array is and can do.
struct Capabilities {
  Input input = Input::points;
  ultrasound::ArrayLayout layout;  // its transducers; devices that take points may leave it out
  std::size_t max_points = 0;      // focal points at a time; 0: any number
  double max_rate = 0.0;           // updates a second that reach the transducers; 0: any number
  std::vector<ultrasound::Modulation> modulations = {
      ultrasound::Modulation::amplitude};  // that submit() can play
  bool slip = false;                       // it plays Emission::slip too
  std::vector<std::string>
      remarks;  // lines that the user should read, such as of an option that may be missing
};

/// An ultrasound array behind its own protocol, loaded by pluginlib under this base class. The safety gate
/// stands in front of every device: it has judged each Sound, so a device plays that and nothing else, solves
/// nothing anew, and may trust positions and intensities to be finite and in range.
class ArrayDevice {
 public:
  virtual ~ArrayDevice() = default;

  /// Whether nobody can be hurt, because there is no array behind it. Only then may rules of the gate be left
  /// out. Asked before open().
  virtual bool harmless() const { return false; }

  /// Opens the array.
  /// @param options as given at launch, such as `port`; those of other devices are to be passed over.
  /// `temperature` (degrees C) is always there: that of the air, for the gate too
  /// @throws std::runtime_error with one line: what, where, what was expected
  virtual void open(const std::map<std::string, std::string>& options) = 0;

  /// Of the open array.
  virtual Capabilities capabilities() const { return {}; }

  /// For arrays that take drives and cannot play any: the drive to play for points that are there at once (an
  /// instant of the emission's period), not modulated down, such that the array can play it exactly: its
  /// phases rounded, its channels on or off. The gate judges it, asks for another one where it is too loud,
  /// and hands the one that passes to submit(). Nothing: the gate solves phases for the layout itself.
  virtual std::optional<ultrasound::Drive> drive(const std::vector<ultrasound::FocalPoint>&) const {
    return std::nullopt;
  }

  /// The same for fields, for arrays that name Modulation::field or field_circle: the patterns to play for
  /// samples of skin, and what they reach there.
  /// @param options of the solver, `amplitude` being the maximum of each transducer that may be spent
  /// @param before patterns of the frame before, or none. Nothing: the gate solves them for the layout
  /// itself.
  virtual std::optional<ultrasound::FieldSolution> field(
      [[maybe_unused]] const std::vector<ultrasound::FocalPoint>& targets,
      [[maybe_unused]] const ultrasound::FieldSolverOptions& options,
      [[maybe_unused]] const std::vector<ultrasound::Drive>& before) const {
    return std::nullopt;
  }

  /// Sends what the gate returned, of a modulation that the device has named, newest wins, without waiting
  /// for the array. It has to be renewed: a device goes silent by itself when nothing is submitted for some
  /// 0.2 s.
  /// @throws std::runtime_error when the array is gone
  virtual void submit(const Sound& sound) = 0;

  /// Silences the array, by the surest means that it has. Must not throw.
  virtual void stop() noexcept = 0;

  /// One line for diagnostics; empty while all is well.
  virtual std::string fault() const = 0;
};

}  // namespace tactile_clay::device
