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
  std::optional<double> pressure;  // Pa, highest peak pressure in the workspace, if known
  std::optional<double> head;      // dB re 20 uPa rms at the head, if known
  std::string where;               // place of `pressure`, as text
};

/// Solves a field.
/// @param amplitude maximum of each transducer, above 0, at most 1
/// @param before the patterns of the frame before; none after silence
/// @param effort share of the solver's work, above 0, at most 1
using SolveField = std::function<ultrasound::FieldSolution(
    const std::vector<ultrasound::FocalPoint>& targets, double amplitude,
    const std::vector<ultrasound::Drive>& before, double effort)>;

/// The array as the gate sees it: its solvers and its loudness.
struct Instrument {
  /// The drive for points that sound at the same time, exactly as the array can play it.
  /// @param before the drive before it; none after silence
  /// @throws std::exception if there is no such drive
  std::function<ultrasound::PhaseSolution(const std::vector<ultrasound::FocalPoint>& points,
                                          const ultrasound::Drive* before)>
      solve;
  /// How loud that drive is.
  /// @param points the points that the drive was made for
  std::function<Loudness(const ultrasound::Drive& drive, const std::vector<ultrasound::FocalPoint>& points)>
      loudness;
  /// Whether the array can play a drive with any share of its amplitudes. If so, a sound that is too loud is
  /// weakened as it is. If not, it is solved anew for weaker points.
  bool scalable = false;
  /// The patterns for a field (ultrasound::isField), exactly as the array can play them. Empty: the array
  /// plays no fields.
  /// @throws as `solve`
  SolveField solve_field = nullptr;
};

/// Solves the parts of the emission's period, one after the other, into `sound.parts`.
/// @param before drive of the frame before; empty after silence
/// @return the loudest of the parts; unknown if one is unknown
Loudness solveParts(const Instrument& instrument, const ultrasound::Drive& before, Sound& sound);

/// Solves the patterns of a field into `sound.parts`: one part for each pattern, which are played in turn. If
/// the field moves in a circle, the patterns are solved for each place on the circle. Each place after the
/// first one starts from the place before and takes a quarter of the effort.
/// @param amplitude as of Instrument::solve_field
/// @param before patterns of the frame before, or none
/// @param field set to the solution; none if there is no solution
/// @return the loudest of the patterns; unknown if one is unknown
Loudness solvePatterns(const Instrument& instrument, double amplitude,
                       const std::vector<ultrasound::Drive>& before, Sound& sound,
                       std::optional<ultrasound::FieldSolution>& field);

/// Multiplies the amplitudes and the loudness of a sound by `factor`: the field is linear.
void weaken(Sound& sound, Loudness& loudness, double factor);

}  // namespace tactile_clay::device
