#pragma once

#include <optional>
#include <string>

#include "device/array_device.h"

namespace tactile_clay::device {

struct SafetyGateConfig {
  double stale_timeout = 0.1;  // s
  Eigen::Vector3d low{-0.20, -0.20,
                      0.05};  // corners of the workspace, m, frame of the array; faces belong to it
  Eigen::Vector3d high{0.20, 0.20, 0.40};
  double intensity_cap = 1.0;          // at most 1
  std::optional<double> head_spl_cap;  // dB re 20 uPa rms at the head; not set: not looked at

  /// \throws std::invalid_argument naming the parameter, its value and its range
  void validate() const;
};

/// The gate's answer: silent where `reason` is not empty. Reasons name the rule, the value and its bound.
struct Verdict {
  std::string reason;
  bool passes() const { return reason.empty(); }
};

/// Stands in front of every array device: an emission passes whole or not at all. The gate starts closed. It
/// holds no clock: ages come in as arguments, so that a lockstep run passes 0 and repeats itself.
class SafetyGate {
 public:
  /// \throws std::invalid_argument as SafetyGateConfig::validate
  explicit SafetyGate(const SafetyGateConfig& config = {});

  /// Opens the gate once the device is open. It does not lift an emergency stop.
  void start() { started_ = true; }

  /// Emergency stop: silent until reset().
  void stop() { stopped_ = true; }

  /// Lifts the emergency stop.
  void reset() { stopped_ = false; }

  bool stopped() const { return stopped_; }

  /// May this emission reach the array? Rules, first come first named: emergency stop, not yet started, stale
  /// (older than the timeout, or from further than that in the future), modulation frequency outside 0 to
  /// 1000 Hz, and for every point: position finite and inside the workspace, intensity finite and 0 to the
  /// cap; sound pressure level at the head known and up to its cap, where there is one. Without points the
  /// last rules have nothing to object to.
  /// \param age of the emission, s
  /// \param head_spl that it causes, dB re 20 uPa rms, if known
  Verdict check(const Emission& emission, double age, std::optional<double> head_spl = std::nullopt) const;

  /// May what the array was last told go on? For a timer of the driver: silent by emergency stop, before the
  /// start and when no emission arrived for longer than the timeout.
  /// \param age_since_last emission that passed, s
  Verdict tick(double age_since_last) const;

 private:
  SafetyGateConfig config_;
  bool started_ = false;
  bool stopped_ = false;
};

}  // namespace tactile_clay::device
