#include "tools/outcome.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "contact/pressure_field.h"
#include "hand/soft_hands.h"
#include "tools/clay_shape.h"

namespace tactile_clay::tools {

namespace {

constexpr double rendered_period = 0.1;  // s, between frames whose rendering is measured
constexpr char rendered_layout[] = "usx";

Load loadOnHands(const clay::Clay& clay, const std::vector<std::uint8_t>& side) {
  Load load = Load::Zero();
  for (const SkinForce& f : clay.skinForces()) load.segment<3>(3 * side[f.index]) += f.force.cast<double>();
  return load;
}

Load loadOnSolids(const clay::Clay& clay) {
  Load load = Load::Zero();
  for (const Eigen::Vector3d& f : clay.solidForces()) load.head<3>() += f;
  return load;
}

/// The hands of a sample: as they were tracked, or soft hands that the clay pushes back.
class Hands {
 public:
  explicit Hands(double soft_skin) {
    if (soft_skin > 0.0) soft_.emplace(soft_skin);
  }

  void go(const HandSample& sample) {
    stamp_ = sample.stamp;
    skin_ = soft_ ? soft_->update(sample.hands, sample.stamp) : sample.skin;
    skin_.weight.assign(skin_.size(), 1.0f);
  }
  const Skin& skin() const { return skin_; }

  /// Gives the forces of the clay to the hands.
  void react(const std::vector<SkinForce>& answer) {
    if (soft_) soft_->react(stamp_, answer);
  }

  void measure(const std::vector<SkinForce>& answer, std::vector<PressureMeter>& meters) const {
    for (PressureMeter& meter : meters) meter.add(skin_, answer);
  }

 private:
  std::optional<hand::SoftHands> soft_;
  std::chrono::nanoseconds stamp_{0};
  Skin skin_;
};

}  // namespace

std::vector<Load> meansOf(const std::vector<TimedLoad>& loads) {
  std::vector<Load> means;
  Load impulse = Load::Zero();
  double time = 0.0;
  for (const TimedLoad& piece : loads) {
    impulse += piece.duration * piece.load;
    time += piece.duration;
    if (time > 0.1 - 1e-9) {  // six frames of 1/60 s are enough, however their sum is rounded
      means.push_back(impulse / time);
      impulse.setZero();
      time = 0.0;
    }
  }
  return means;
}

Outcome play(const scene::Scene& scene, const scene::Solids& solids, const std::vector<HandSample>& samples,
             const clay::Budget& budget, const PlayOptions& options) {
  clay::ClayConfig config = scene.config;
  config.budget = budget;
  config.threads = options.threads;
  config.sleeping = false;  // only the solver is compared
  clay::Clay clay(config, scene.materials, scene.particles);
  const double first_volume = volumeOf(clay.particles().position, config.spacing);
  const double step = config.timeStep();
  const bool with_hands = std::any_of(samples.begin(), samples.end(),
                                      [](const HandSample& sample) { return sample.skin.size() > 0; });
  Hands hands(options.soft_skin);
  std::vector<PressureMeter> meters;
  for (const Rendering& rendering : options.renderings)
    meters.emplace_back(rendering, rendered_layout, options.array);
  Outcome outcome;
  std::vector<TimedLoad> loads;
  double time = 0.0, since_rendered = 0.0;
  for (const HandSample& sample : samples) {
    hands.go(sample);
    const double before = clay.time();
    const auto start = std::chrono::steady_clock::now();
    clay.advance(hands.skin(), solids.solids(), solids.motion(), sample.duration);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    // A recorded sample may be shorter than a time step, or longer than a frame.
    const long steps = std::lround((clay.time() - before) / step);
    if (steps > 0)
      outcome.ms.push_back(ms / static_cast<double>(steps) * static_cast<double>(budget.substeps));

    hands.react(clay.skinForces());
    since_rendered += sample.duration;
    if (!meters.empty() && since_rendered >= rendered_period - 1e-9) {
      hands.measure(clay.skinForces(), meters);
      since_rendered = 0.0;
    }

    const Load load = with_hands ? loadOnHands(clay, hands.skin().side) : loadOnSolids(clay);
    loads.push_back({sample.duration, load});
    time += sample.duration;
    outcome.mean_force += sample.duration * load.norm();
    outcome.density += sample.duration * clay.statistics().density_error_mean;
    outcome.densest = std::max(outcome.densest, clay.statistics().density_error_max);
  }
  if (time > 0.0) {
    outcome.mean_force /= time;
    outcome.density /= time;
  }
  for (const PressureMeter& meter : meters) outcome.rendered.push_back(meter.mean());
  outcome.force = meansOf(loads);
  outcome.position = clay.particles().position;
  outcome.height = heightOf(outcome.position, solids.at(clay.time()), config.gravity, config.spacing);
  outcome.volume_change = volumeOf(outcome.position, config.spacing) / first_volume - 1.0;
  return outcome;
}

Errors compare(const Outcome& outcome, const Outcome& reference, double spacing) {
  Errors e;
  for (std::size_t i = 0; i < reference.position.size(); ++i)
    e.displacement += (outcome.position.at(i) - reference.position.at(i)).cast<double>().squaredNorm();
  e.displacement = std::sqrt(e.displacement / static_cast<double>(reference.position.size())) / spacing;
  e.height = reference.height > 0.0 ? outcome.height / reference.height - 1.0 : NAN;
  double difference = 0.0, size = 0.0;
  for (std::size_t k = 0; k < reference.force.size(); ++k) {
    difference += (outcome.force[k] - reference.force[k]).squaredNorm();
    size += reference.force[k].squaredNorm();
  }
  e.force = size > 0.0 ? std::sqrt(difference / size) : NAN;
  e.mean_force = reference.mean_force > 0.0 ? outcome.mean_force / reference.mean_force - 1.0 : NAN;
  return e;
}

Errors max(const Errors& a, const Errors& b) {
  Errors maximum;
  for (double Errors::*error : {&Errors::displacement, &Errors::height, &Errors::force, &Errors::mean_force})
    maximum.*error = std::max(std::abs(a.*error), std::abs(b.*error));
  return maximum;
}

}  // namespace tactile_clay::tools
