#include "device/safety_gate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "values/text.h"

namespace tactile_clay::device {
namespace {

using values::text;

constexpr double max_modulation = 1000.0;  // Hz; nobody feels higher frequencies
constexpr double longest_rise = 0.1;       // s; after a longer pause intensities rise as after this one
constexpr double same_place = 0.010;       // m; half of a focus, and the way of a hand at 0.6 m/s in a frame
constexpr int rounds = 6;                  // of weakening: a drive need not be proportional to its points

std::string name(const ultrasound::FocalPoint& point) {
  return "focal point " + std::to_string(point.id);
}

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("safety gate: " + what);
}

}  // namespace

SafetyGate::SafetyGate(const SafetyGateConfig& config, Instrument instrument)
    : config_(config), first_(config), instrument_(std::move(instrument)) {
  config_.validate();
}

void SafetyGate::tighten(const SafetyGateConfig& config, Instrument instrument) {
  config.validate();
  for (const Limit& limit : limits)
    require(config.*limit.value <= first_.*limit.value,
            limit.name + (" is " + text(config.*limit.value)) + ", expected at most the " +
                text(first_.*limit.value) +
                " of the start: the gate is never made less strict while it runs");
  require((config.low.array() >= first_.low.array()).all() &&
              (config.high.array() <= first_.high.array()).all() && config.without == first_.without,
          "another workspace or other rules, expected those of the start");
  config_ = config;
  instrument_ = std::move(instrument);
}

void SafetyGate::stop() {
  stopped_ = true;
  fallSilent();
}

void SafetyGate::fallSilent() {
  intensities_.clear();
  last_ = {};
  field_.clear();
  given_.clear();
}

Verdict SafetyGate::tick(double age_since_last) const {
  Verdict verdict;
  if (applies(Rule::emergency_stop) && stopped_)
    verdict.reason = "emergency stop: silent until it is reset";
  else if (applies(Rule::not_started) && !started_)
    verdict.reason = "not started: the device is not open yet";
  // Written so that NaN counts as stale.
  else if (applies(Rule::stale) &&
           !(age_since_last <= config_.stale_timeout && age_since_last >= -config_.stale_timeout))
    verdict.reason = "stale: focal points are " + text(1e-4 * std::round(1e4 * age_since_last)) +
                     " s old, expected at most " + text(config_.stale_timeout) + " s";
  return verdict;
}

std::string SafetyGate::objection(const ultrasound::FocalPoint& point, bool field) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double x = point.position[axis];
    const std::string coordinate = std::string(1, "xyz"[axis]) + " of " + name(point) + " is " + text(x);
    if (applies(Rule::non_finite) && !std::isfinite(x))
      return "non-finite: " + coordinate + ", expected a finite number of m";
    const bool silent = field && point.intensity == 0.0;  // there is skin, and nothing is to be felt
    if (applies(Rule::workspace) && !silent && (x < config_.low[axis] || x > config_.high[axis])) {
      return "outside the workspace: " + coordinate + " m, expected " + text(config_.low[axis]) + " to " +
             text(config_.high[axis]) + " m";
    }
  }
  const std::string intensity = "intensity of " + name(point) + " is " + text(point.intensity);
  if (applies(Rule::non_finite) && !std::isfinite(point.intensity))
    return "non-finite: " + intensity + ", expected a finite number";
  if (applies(Rule::non_finite) && field && !(point.weight >= 0.0 && std::isfinite(point.weight)))
    return "non-finite: weight of " + name(point) + " is " + text(point.weight) +
           ", expected 0 or a positive number";
  if (applies(Rule::non_finite) && field && !point.normal.allFinite())
    return "non-finite: normal of " + name(point) + ", expected three finite numbers";
  if (applies(Rule::intensity) && (point.intensity < 0.0 || point.intensity > config_.intensity_cap))
    return "intensity out of range: " + intensity + ", expected 0 to " + text(config_.intensity_cap);
  return "";
}

std::string SafetyGate::objection(const Emission& emission, const Occasion& occasion) const {
  if (applies(Rule::hand_lost)) {
    if (!occasion.hands_tracked) return "hand lost: no hand is tracked, expected one where focal points are";
    if (!(occasion.hands_age <= config_.stale_timeout))
      return "hand lost: no word of the hands for " + text(occasion.hands_age) + " s, expected one every " +
             text(config_.stale_timeout) + " s";
  }
  const double frequency = emission.modulation_frequency;
  if (applies(Rule::modulation) && !(frequency >= 0.0 && frequency <= max_modulation))
    return "modulation: frequency is " + text(frequency) + " Hz, expected 0 to " + text(max_modulation) +
           " Hz";
  if (applies(Rule::modulation) && frequency == 0.0 &&
      emission.modulation != ultrasound::Modulation::amplitude)
    return std::string("modulation: frequency is 0 Hz, expected more for ") +
           ultrasound::nameOf(emission.modulation);
  if (applies(Rule::modulation) && !(emission.slip >= 0.0 && emission.slip <= 1.0))
    return "modulation: slip is " + text(emission.slip) + ", expected 0 to 1";
  for (const ultrasound::Part& part : ultrasound::parts(period(emission))) {
    for (const ultrasound::FocalPoint& point : part.points) {
      std::string reason = objection(point, ultrasound::isField(emission.modulation));
      if (!reason.empty()) return reason;
    }
  }
  return "";
}

bool SafetyGate::limitSlew(Verdict& verdict, double since_last) const {
  if (!applies(Rule::slew)) return false;
  bool limited = false;
  const double time = since_last > 0.0 ? std::min(since_last, longest_rise) : 0.0;  // NaN counts as 0
  std::vector<ultrasound::FocalPoint>& points = verdict.sound.emission.points;
  const std::vector<double> before = intensities_.of(points);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double maximum = before[k] + config_.intensity_slew * time;
    if (points[k].intensity <= maximum) continue;
    points[k].intensity = maximum;
    verdict.lowered = "slew: intensity rises by at most " + text(config_.intensity_slew) + " per second";
    limited = true;
  }
  return limited;
}

/// Factor that lowers a field so that at no skin sample the sound rises faster than the slew.
double SafetyGate::rise(const ultrasound::FieldSolution& field,
                        const std::vector<ultrasound::FocalPoint>& targets, double since_last) const {
  const double time = since_last > 0.0 ? std::min(since_last, longest_rise) : 0.0;  // NaN counts as 0
  double factor = 1.0;
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const Eigen::Vector3d& at = targets[k].position;
    double before = 0.0;
    auto given = std::partition_point(given_.begin(), given_.end(),
                                      [&](const Given& g) { return g.position.x() < at.x() - same_place; });
    for (; given != given_.end() && given->position.x() <= at.x() + same_place; ++given)
      if (given->share > before && (given->position - at).norm() <= same_place) before = given->share;
    const double maximum = (before + config_.intensity_slew * time) * field.reach[k];
    if (field.reached[k] > maximum) factor = std::min(factor, maximum / field.reached[k]);
  }
  return factor;
}

void SafetyGate::limitField(Verdict& verdict, double since_last) const {
  Sound& sound = verdict.sound;
  double margin = 0.995;  // as in limitLoudness
  double amplitude = 1.0;
  bool anew = true;
  Loudness loudness;
  for (int round = 0; round < rounds; ++round) {
    if (anew) loudness = solvePatterns(instrument_, amplitude, field_, sound, verdict.field);
    verdict.head_spl = loudness.head;
    verdict.reason.clear();
    double factor = excess(loudness, verdict.reason);
    if (!verdict.passes()) {
      if (!(factor > 0.0)) return;  // unknown, or NaN
      verdict.lowered = verdict.reason;
      // In round 0 solve anew with less amplitude. Later lower all in proportion, if the array can.
      anew = round == 0 || !instrument_.scalable;
    } else {
      if (!verdict.field || !applies(Rule::slew)) return;
      factor = rise(*verdict.field, sound.emission.points, since_last);
      if (factor >= 1.0) return;
      verdict.lowered = "slew: intensity rises by at most " + text(config_.intensity_slew) + " per second";
      verdict.reason = verdict.lowered;
      anew = !instrument_.scalable && factor > 0.0;
    }
    if (anew) {
      amplitude *= margin * factor;
    } else {
      const double by = factor > 0.0 ? margin * factor : 0.0;
      weaken(sound, loudness, by);
      if (verdict.field)
        for (auto* amplitudes : {&verdict.field->reached, &verdict.field->on_skin})
          for (double& pascals : *amplitudes) pascals *= by;
    }
    margin *= margin * margin;
  }
}

/// @param reason is set if the sound is too loud
/// @return factor that the amplitudes have to be multiplied by; 1: not too loud; 0: silence
double SafetyGate::excess(const Loudness& loudness, std::string& reason) const {
  double factor = 1.0;
  if (applies(Rule::pressure)) {
    const std::string expected = ", expected at most " + text(config_.pressure_cap) + " Pa";
    if (!loudness.pressure) {
      reason = "pressure: not known" + expected;
      return 0.0;
    }
    if (!(*loudness.pressure <= config_.pressure_cap)) {
      factor = config_.pressure_cap / *loudness.pressure;
      reason = "pressure: " + text(*loudness.pressure) + " Pa" + loudness.where + expected;
    }
  }
  if (applies(Rule::head_level)) {
    const std::string expected = ", expected at most " + text(config_.head_spl_cap) + " dB";
    if (!loudness.head) {
      reason = "head level: not known" + expected;
      return 0.0;
    }
    if (!(*loudness.head <= config_.head_spl_cap)) {
      factor = std::min(factor, std::pow(10.0, (config_.head_spl_cap - *loudness.head) / 20.0));
      reason = "head level: " + text(*loudness.head) + " dB" + expected;
    }
  }
  return factor;
}

void SafetyGate::limitLoudness(Verdict& verdict) const {
  // The margin covers the rounding of a drive. It grows, because boards that switch channels off get weaker
  // in steps.
  double margin = 0.995;
  Loudness loudness;
  for (int round = 0; round < rounds; ++round) {
    if (round == 0 || !instrument_.scalable) loudness = solveParts(instrument_, last_, verdict.sound);
    verdict.head_spl = loudness.head;
    verdict.reason.clear();
    const double factor = excess(loudness, verdict.reason);
    if (verdict.passes()) return;
    if (!(factor > 0.0)) return;  // unknown, or NaN
    verdict.lowered = verdict.reason;
    weaken(verdict.sound, loudness, margin * factor);
    margin *= margin * margin;
  }
}

Verdict SafetyGate::check(const Emission& emission, const Occasion& occasion) {
  Verdict verdict = tick(occasion.age);
  if (verdict.passes()) {
    verdict.sound.emission = emission;
    if (!emission.points.empty()) {
      verdict.reason = objection(emission, occasion);
      if (verdict.passes() && ultrasound::isField(emission.modulation)) {
        limitField(verdict, occasion.since_last);
      } else {
        // Loudness first: the slew then compares lowered intensities, here and in the emission before.
        if (verdict.passes()) limitLoudness(verdict);
        if (verdict.passes() && limitSlew(verdict, occasion.since_last)) limitLoudness(verdict);
      }
    }
  }
  fallSilent();
  if (!verdict.passes()) {
    verdict.sound = {};
    verdict.head_spl.reset();
    verdict.field.reset();
  }
  keep(verdict);
  return verdict;
}

/// Stores what the next emission starts from.
void SafetyGate::keep(const Verdict& verdict) {
  const Sound& sound = verdict.sound;
  if (sound.parts.empty()) return;
  if (!verdict.field) {
    intensities_.set(sound.emission.points, [](const auto& point) { return point.intensity; });
    last_ = sound.parts.back().drive;
    return;
  }
  for (const Sound::Part& part : sound.parts) field_.push_back(part.drive);
  for (std::size_t k = 0; k < sound.emission.points.size(); ++k)
    if (verdict.field->reach[k] > 0.0)
      given_.push_back(
          {sound.emission.points[k].position, verdict.field->reached[k] / verdict.field->reach[k]});
  std::sort(given_.begin(), given_.end(),
            [](const Given& a, const Given& b) { return a.position.x() < b.position.x(); });
}

}  // namespace tactile_clay::device
