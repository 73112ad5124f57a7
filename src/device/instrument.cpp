#include "device/instrument.h"

#include <cmath>
#include <exception>
#include <utility>

namespace tactile_clay::device {
namespace {

/// The loudest of several. Unknown or NaN at one instant is unknown or NaN for all.
class Loudest {
 public:
  void add(const Loudness& now) {
    if (louder(now.pressure, most_.pressure)) {
      most_.pressure = now.pressure;
      most_.where = now.where;
    }
    if (louder(now.head, most_.head)) most_.head = now.head;
    first_ = false;
  }
  const Loudness& get() const { return most_; }

 private:
  bool louder(const std::optional<double>& now, const std::optional<double>& most) const {
    if (first_) return true;
    return most && (!now || (!(*now <= *most) && !std::isnan(*most)));
  }

  Loudness most_;
  bool first_ = true;
};

}  // namespace

Loudness solveParts(const Instrument& instrument, const ultrasound::Drive& last, Sound& sound) {
  Loudest loudest;
  sound.parts.clear();
  for (ultrasound::Part& part : ultrasound::parts(period(sound.emission))) {
    const ultrasound::Drive* before = sound.parts.empty() ? &last : &sound.parts.back().drive;
    if (before->phase.empty()) before = nullptr;
    Loudness now;
    Sound::Part solved;
    try {
      ultrasound::PhaseSolution solution = instrument.solve(part.points, before);
      now = instrument.loudness(solution.drive, part.points);
      solved.drive = std::move(solution.drive);
      solved.target = std::move(solution.target);
    } catch (const std::exception&) {
      // Not known: what is wrong is told by its rule.
    }
    solved.what = std::move(part);
    sound.parts.push_back(std::move(solved));
    loudest.add(now);
  }
  return loudest.get();
}

Loudness solvePatterns(const Instrument& instrument, double amplitude,
                       const std::vector<ultrasound::Drive>& before, Sound& sound,
                       std::optional<ultrasound::FieldSolution>& field) {
  Loudest loudest;
  sound.parts.clear();
  field.reset();
  try {
    field = instrument.solve_field(sound.emission.points, amplitude, before);
    const std::size_t patterns = field->drives.size();
    const std::vector<ultrasound::Instant> instants = period(sound.emission);
    for (std::size_t k = 0; k < patterns; ++k) {
      loudest.add(instrument.loudness(field->drives[k], sound.emission.points));
      ultrasound::Part part{sound.emission.points, instants.front().which, {}, 0.0, 0.0};
      for (std::size_t i = k; i < instants.size(); i += patterns) {
        const double share = 1.0 / static_cast<double>(instants.size());
        part.instants.push_back(i);
        part.time += share;
        part.power += share * instants[i].amplitude * instants[i].amplitude;
      }
      sound.parts.push_back({std::move(part), field->drives[k], field->wanted});
    }
  } catch (const std::exception&) {
    return {};  // not known
  }
  return loudest.get();
}

void weaken(Sound& sound, Loudness& loudness, double factor) {
  for (ultrasound::FocalPoint& point : sound.emission.points) point.intensity *= factor;
  for (Sound::Part& part : sound.parts) {
    for (ultrasound::FocalPoint& point : part.what.points) point.intensity *= factor;
    for (float& amplitude : part.drive.amplitude) amplitude *= static_cast<float>(factor);
    for (double& target : part.target) target *= factor;
  }
  if (loudness.pressure) *loudness.pressure *= factor;
  if (loudness.head) *loudness.head += 20.0 * std::log10(factor);
}

}  // namespace tactile_clay::device
