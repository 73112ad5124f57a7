#include "device/instrument.h"

#include <cmath>
#include <exception>
#include <utility>

namespace tactile_clay::device {
namespace {

/// The loudest of several. If one is unknown or NaN, the result is unknown or NaN.
class Loudest {
 public:
  void add(const Loudness& now) {
    if (louder(now.pressure, maximum_.pressure)) {
      maximum_.pressure = now.pressure;
      maximum_.where = now.where;
    }
    if (louder(now.head, maximum_.head)) maximum_.head = now.head;
    first_ = false;
  }
  const Loudness& get() const { return maximum_; }

 private:
  bool louder(const std::optional<double>& now, const std::optional<double>& maximum) const {
    if (first_) return true;
    return maximum && (!now || (!(*now <= *maximum) && !std::isnan(*maximum)));
  }

  Loudness maximum_;
  bool first_ = true;
};

constexpr double circle_effort = 0.25;  // for a place about 2 mm from one that is solved

/// The patterns of each place on a circle, one place after the other. Amplitudes are root mean squares
/// over the places.
ultrasound::FieldSolution solveCircle(const Instrument& instrument, double amplitude,
                                      const std::vector<ultrasound::Drive>& before,
                                      const std::vector<ultrasound::Instant>& places) {
  ultrasound::FieldSolution all;
  const std::size_t count = places.front().points->size();
  std::vector<double> wanted(count, 0.0), reached(count, 0.0), on_skin(count, 0.0);
  const auto over = static_cast<double>(places.size());
  all.reach.assign(count, 0.0);
  std::vector<ultrasound::Drive> last(
      before.begin(), before.begin() + static_cast<std::ptrdiff_t>(before.size() / places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) {
    const ultrasound::FieldSolution here =
        instrument.solve_field(*places[k].points, amplitude, last, k == 0 ? 1.0 : circle_effort);
    for (std::size_t m = 0; m < count; ++m) {
      all.reach[m] += here.reach.at(m) / over;
      wanted[m] += here.wanted.at(m) * here.wanted[m] / over;
      reached[m] += here.reached.at(m) * here.reached[m] / over;
      on_skin[m] += here.on_skin.at(m) * here.on_skin[m] / over;
    }
    all.drives.insert(all.drives.end(), here.drives.begin(), here.drives.end());
    last = here.drives;
  }
  for (std::size_t m = 0; m < count; ++m) {
    all.wanted.push_back(std::sqrt(wanted[m]));
    all.reached.push_back(std::sqrt(reached[m]));
    all.on_skin.push_back(std::sqrt(on_skin[m]));
  }
  const ultrasound::FieldFit fit = ultrasound::fieldFit(all.wanted, all.on_skin);
  all.error = fit.error;
  all.scale = fit.scale;
  return all;
}

/// The instants at which pattern k of this number of patterns is played.
void share(const std::vector<ultrasound::Instant>& instants, std::size_t k, std::size_t patterns,
           ultrasound::Part& part) {
  for (std::size_t i = k; i < instants.size(); i += patterns) {
    const double time = 1.0 / static_cast<double>(instants.size());
    part.instants.push_back(i);
    part.time += time;
    part.power += time * instants[i].amplitude * instants[i].amplitude;
  }
}

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
      // The loudness stays unknown. The rule of the gate reports this.
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
    const std::vector<ultrasound::Instant> instants = period(sound.emission);
    const bool circles = sound.emission.modulation == ultrasound::Modulation::field_circle;
    field = circles ? solveCircle(instrument, amplitude, before, instants)
                    : instrument.solve_field(sound.emission.points, amplitude, before, 1.0);
    const std::size_t patterns = field->drives.size();
    for (std::size_t k = 0; k < patterns; ++k) {
      const auto& place = instants[circles ? k * instants.size() / patterns : 0];
      loudest.add(instrument.loudness(field->drives[k], *place.points));
      ultrasound::Part part{*place.points, *place.which, {}, 0.0, 0.0};
      if (circles) {
        part.instants = {k};
        part.time = 1.0 / static_cast<double>(patterns);
        part.power = part.time * place.amplitude * place.amplitude;
      } else {
        share(instants, k, patterns, part);
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
