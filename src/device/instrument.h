#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device/array_device.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::device {

/// How loud a drive is.
struct Loudness {
  std::optional<double> pressure;  // Pa, highest peak pressure anywhere in the workspace, if known
  std::optional<double> head;      // dB re 20 uPa rms at the head, if known
  std::string where;               // of `pressure`, for people
};

/// Solves a field.
/// @param amplitude most of each transducer, above 0, at most 1
/// @param before the patterns before; none after silence
/// @param effort share of its work to spend, above 0, at most 1
using SolveField = std::function<ultrasound::FieldSolution(
    const std::vector<ultrasound::FocalPoint>& targets, double amplitude,
    const std::vector<ultrasound::Drive>& before, double effort)>;

/// The array that the gate judges for.
struct Instrument {
  /// The drive for points that are there at once, exactly as the array can play it.
  /// @param before the drive before it; none after silence.
  /// @throws std::exception where it cannot be known
  std::function<ultrasound::PhaseSolution(const std::vector<ultrasound::FocalPoint>& points,
                                          const ultrasound::Drive* before)>
      solve;
  /// How loud that drive is.
  /// @param points that it was made for
  std::function<Loudness(const ultrasound::Drive& drive, const std::vector<ultrasound::FocalPoint>& points)>
      loudness;
  /// A drive can be played with any share of its amplitudes: a sound that is too loud is then weakened as it
  /// is. Else it is solved anew for weaker points.
  bool scalable = false;
  /// The patterns for a field, exactly as the array can play them (ultrasound::isField).
  /// @throws as `solve`. Empty: the array plays no fields
  SolveField solve_field = nullptr;
};

/// Solves the parts of the emission's period, one after the other, into `sound.parts`.
/// @param before drive of the frame before; empty after silence
/// @return the loudest of them; not known where one is not
Loudness solveParts(const Instrument& instrument, const ultrasound::Drive& before, Sound& sound);

/// Solves the patterns of a field into `sound.parts`: a part each, that take turns. Where the field goes
/// round in a circle, each of its places is solved, with a quarter of the effort from the place before.
/// @param amplitude as of Instrument::solve_field
/// @param before patterns of the frame before, or none
/// @param field set to the solution; none where it cannot be known
/// @return the loudest of them; not known where one is not
Loudness solvePatterns(const Instrument& instrument, double amplitude,
                       const std::vector<ultrasound::Drive>& before, Sound& sound,
                       std::optional<ultrasound::FieldSolution>& field);

/// All of a sound in proportion, its loudness too: the field is linear.
void weaken(Sound& sound, Loudness& loudness, double factor);

}  // namespace tactile_clay::device
