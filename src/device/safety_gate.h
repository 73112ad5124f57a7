#pragma once

#include <optional>
#include <string>
#include <vector>

#include "device/array_device.h"
#include "device/instrument.h"
#include "device/point_values.h"
#include "device/safety_limits.h"
#include "ultrasound/field_solver.h"

namespace tactile_clay::device {

/// When an emission came, and what is known about the hands at that time.
struct Occasion {
  double age = 0.0;           // s, of the emission
  double since_last = 0.0;    // s, since the emission before
  bool hands_tracked = true;  // the tracker sees a hand
  double hands_age = 0.0;     // s, since the last message about the hands
};

/// The gate's answer. If `reason` is not empty, the array has to be silent; `reason` names the rule, the
/// value and its limit.
struct Verdict {
  std::string reason;
  Sound sound;                     // all that may sound
  std::string lowered;             // why its points are weaker than asked for; empty: they are not
  std::optional<double> head_spl;  // level of the sound at the head, dB, if known
  std::optional<ultrasound::FieldSolution> field;  // solution, if the sound is a field
  bool passes() const { return reason.empty(); }
};

/// Stands in front of every array device and decides: it judges an emission and returns what may sound, with
/// exactly the drives that it judged. An invalid point silences the whole emission. An emission that is only
/// too loud is made weaker. The gate is closed at first. It has no clock: times are arguments. In lockstep
/// ages are 0 and `since_last` follows from the stamps, so that a run is repeatable.
class SafetyGate {
 public:
  /// @throws std::invalid_argument as SafetyGateConfig::validate
  SafetyGate(const SafetyGateConfig& config, Instrument instrument);

  /// Opens the gate once the device is open. It does not lift an emergency stop.
  void start() { started_ = true; }

  /// Emergency stop: silent until reset().
  void stop();

  /// Lifts the emergency stop. Points then start from intensity 0 again.
  void reset() { stopped_ = false; }

  /// Sets other limits. None may be less strict than at the start. A sound goes on.
  /// @param instrument judges by the new limits
  /// @throws std::invalid_argument with one line if a limit is less strict; the gate then stays as it was
  void tighten(const SafetyGateConfig& config, Instrument instrument);

  bool stopped() const { return stopped_; }
  const SafetyGateConfig& config() const { return config_; }

  /// To be called if the array was silenced, but not by check(). Points then start from intensity 0 again.
  void fallSilent();

  /// Judges which part of an emission may reach the array. Rules, in this order; the first that fails is
  /// named:
  ///
  /// Silent:
  /// - emergency stop
  /// - not yet started
  /// - stale: older than the timeout, or more than the timeout in the future
  ///
  /// Silent, only if there are points:
  /// - hand lost: no hand is tracked, or no message about the hands came for longer than the timeout
  /// - modulation frequency outside 0 to 1000 Hz; 0 is allowed for amplitude modulation only
  /// - slip outside 0 to 1
  /// - a position or intensity that is not finite; in a field also a weight that is not finite, or negative,
  ///   and a normal that is not finite
  /// - a position outside the workspace at any instant of the period
  /// - an intensity outside 0 to the cap
  ///
  /// Weaker:
  /// - All intensities are lowered together until the highest pressure in the workspace and the level at the
  ///   head are within their caps at every instant of the period.
  /// - Then a point's intensity rises no faster than the slew, from 0 for a new point (STM: each place of the
  ///   path is a point).
  /// - If pressure or level are unknown, or lowering does not bring them below the caps, the array is silent.
  ///
  /// In a field the points are skin samples (with `field_circle`, at each place of the circle). Samples of
  /// intensity 0 may lie outside the workspace. Pressure and level are checked for each pattern, on the
  /// samples and beside them. The slew rule applies to each sample, touched or not. Its quantity is the
  /// amplitude there without skin, divided by the amplitude of the whole array focused there. This share
  /// rises no faster than the slew, from the highest share within 10 mm of the sample in the emission before.
  Verdict check(const Emission& emission, const Occasion& occasion);

  /// Whether the last emission may go on; for a timer of the driver. The array has to be silent during an
  /// emergency stop, before the start, and if no emission arrived for longer than the timeout.
  /// @param age_since_last s, since the last emission that passed
  Verdict tick(double age_since_last) const;

 private:
  bool applies(Rule rule) const { return config_.without.count(rule) == 0; }
  std::string objection(const Emission& emission, const Occasion& occasion) const;
  std::string objection(const ultrasound::FocalPoint& point, bool field) const;
  bool limitSlew(Verdict& verdict, double since_last) const;  // returns whether it lowered an intensity
  void limitLoudness(Verdict& verdict) const;
  void limitField(Verdict& verdict, double since_last) const;
  double rise(const ultrasound::FieldSolution& field, const std::vector<ultrasound::FocalPoint>& targets,
              double since_last) const;
  void keep(const Verdict& verdict);
  double excess(const Loudness& loudness, std::string& reason) const;

  SafetyGateConfig config_;
  SafetyGateConfig first_;  // limits at the start
  Instrument instrument_;
  bool started_ = false;
  bool stopped_ = false;
  PointValues intensities_;               // intensities of the points that passed last
  ultrasound::Drive last_;                // drive of these points; empty after silence and fields
  std::vector<ultrasound::Drive> field_;  // the patterns that passed last; empty after silence and points
  struct Given {
    Eigen::Vector3d position;
    double share;  // amplitude there, over that of the whole array focused there
  };
  std::vector<Given> given_;  // shares that these patterns reached, at each sample, by ascending x
};

}  // namespace tactile_clay::device
