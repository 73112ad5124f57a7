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

/// When an emission came, and what is known of the hands at that time.
struct Occasion {
  double age = 0.0;           // s, of the emission
  double since_last = 0.0;    // s, since the emission before
  bool hands_tracked = true;  // the tracker sees a hand
  double hands_age = 0.0;     // s, since the tracker said anything
};

/// The gate's answer. Silent where `reason` is not empty; it names the rule, the value and its bound.
struct Verdict {
  std::string reason;
  Sound sound;                                     // what may sound, and nothing else
  std::string lowered;                             // why its points are weaker than asked for, if so
  std::optional<double> head_spl;                  // of it, dB, if known
  std::optional<ultrasound::FieldSolution> field;  // where the sound is one
  bool passes() const { return reason.empty(); }
};

/// Stands in front of every array device and has the last word: it judges an emission and returns what may
/// sound, with the very drives that it judged. A bad point silences the whole emission; one that is only too
/// loud is made weaker. The gate starts closed. It holds no clock: times come in as arguments, so that a
/// lockstep run passes 0 and repeats itself.
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

  /// Other limits, none of them less strict than at the start. What sounds goes on.
  /// @param instrument that judges by them
  /// @throws std::invalid_argument with one line where one is less strict, and the gate stays as it was
  void tighten(const SafetyGateConfig& config, Instrument instrument);

  bool stopped() const { return stopped_; }
  const SafetyGateConfig& config() const { return config_; }

  /// The array was silenced by other means than check(). Points then start from intensity 0 again.
  void fallSilent();

  /// What of this emission may reach the array? Rules, first come first named:
  /// - silent: emergency stop, not yet started, stale (older than the timeout, or from further than that in
  ///   the future); and, where there are points: hand lost (no hand is tracked, or no word of the hands for
  ///   longer than the timeout), modulation frequency outside 0 to 1000 Hz (0: amplitude modulation only),
  ///   slip outside 0 to 1, a position or intensity that is not finite, a position outside the workspace at
  ///   any instant of the period, an intensity outside 0 to the cap
  /// - weaker: all intensities are lowered together until the highest pressure in the workspace and the level
  ///   at the head keep to their caps at every instant of the period; then a point's intensity rises no
  ///   faster than the slew, from 0 for a new point (STM: each place of the path is a point). Silent where
  ///   they are not known, or where that does not come about
  ///
  /// Of a field the points are samples of skin (of `field_circle` at each place of the circle). Those of
  /// intensity 0 may lie outside the workspace. Loudness is that of each of its patterns, on samples and
  /// beside them; the slew holds for what the field does at each sample, touched or not: the share of what
  /// the whole array could have there rises no faster than the slew from the highest that was given within 10
  /// mm of it in the emission before.
  Verdict check(const Emission& emission, const Occasion& occasion);

  /// May what the array was last told go on? For a timer of the driver: silent by emergency stop, before the
  /// start and when no emission arrived for longer than the timeout.
  /// @param age_since_last emission that passed, s
  Verdict tick(double age_since_last) const;

 private:
  bool applies(Rule rule) const { return config_.without.count(rule) == 0; }
  std::string objection(const Emission& emission, const Occasion& occasion) const;
  std::string objection(const ultrasound::FocalPoint& point, bool field) const;
  bool limitSlew(Verdict& verdict, double since_last) const;  // whether it did
  void limitLoudness(Verdict& verdict) const;
  void limitField(Verdict& verdict, double since_last) const;
  double rise(const ultrasound::FieldSolution& field, const std::vector<ultrasound::FocalPoint>& targets,
              double since_last) const;
  void keep(const Verdict& verdict);
  double excess(const Loudness& loudness, std::string& reason) const;

  SafetyGateConfig config_;
  SafetyGateConfig first_;  // at the start
  Instrument instrument_;
  bool started_ = false;
  bool stopped_ = false;
  PointValues intensities_;               // of the points that passed last
  ultrasound::Drive last_;                // of them; empty after silence
  std::vector<ultrasound::Drive> field_;  // the patterns that passed last; empty after silence and points
  struct Given {
    Eigen::Vector3d position;
    double share;  // of what the array could have there, in amplitude
  };
  std::vector<Given> given_;  // by them, at each sample
};

}  // namespace tactile_clay::device
