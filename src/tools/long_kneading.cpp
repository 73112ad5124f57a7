#include "tools/long_kneading.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "clay/live_pace.h"
#include "clay/neighbourhood.h"
#include "clay/skin_path.h"
#include "tools/clay_shape.h"
#include "tools/quantile.h"

namespace tactile_clay::tools {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

double residentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double size = 0.0, resident = 0.0;  // pages
  statm >> size >> resident;
  return 1e-6 * resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double neighboursOf(const clay::Clay& clay) {
  const clay::VectorField& position = clay.particles().position;
  clay::Neighbourhood near(static_cast<float>(2.0 * clay.config().spacing));
  near.build(position);
  double sum = 0.0;
  for (std::size_t i = 0; i < position.size(); ++i) sum += near.count(i);
  return sum / static_cast<double>(position.size());
}

/// The clock of a live run: that of this computer, or that of a computer whose frames take `slowness` times
/// their simulated time.
class LiveClock {
 public:
  /// @param slowness 0: the clock of this computer
  explicit LiveClock(double slowness) : slowness_(slowness) {}

  /// Time since the start, s.
  double now() const { return slowness_ > 0.0 ? now_ : Seconds(Clock::now() - start_).count(); }

  void waitUntil(double time) {
    if (slowness_ > 0.0)
      now_ = std::max(now_, time);
    else
      std::this_thread::sleep_until(start_ + std::chrono::duration_cast<Clock::duration>(Seconds(time)));
  }

  /// To be called when a frame was computed.
  /// @param simulated s, simulated time of the frame
  /// @param took s, on this computer
  /// @return its duration by this clock, s
  double computed(double simulated, double took) {
    if (!(slowness_ > 0.0)) return took;
    now_ += slowness_ * simulated;
    return slowness_ * simulated;
  }

  /// Leaves the last `duration` s out of the run.
  void setAside(double duration) {
    if (!(slowness_ > 0.0)) start_ += std::chrono::duration_cast<Clock::duration>(Seconds(duration));
  }

 private:
  double slowness_, now_ = 0.0;
  Clock::time_point start_ = Clock::now();
};

/// Sums of the frames of a stretch.
class Sums {
 public:
  void add(const clay::Clay& clay, double ms, double cpu_ms) {
    const clay::Statistics& s = clay.statistics();
    const std::vector<SkinForce>& forces = clay.skinForces();
    sum_.touched += static_cast<double>(std::count_if(
        forces.begin(), forces.end(), [](const SkinForce& f) { return f.force.squaredNorm() > 0.0f; }));
    ms_.push_back(ms);
    sum_.cpu_ms += cpu_ms;
    sum_.awake += static_cast<double>(s.awake);
    sum_.contacts += static_cast<double>(s.contacts);
    sum_.iterations += s.iterations;
    sum_.rounds += s.rounds;
    sum_.lumps += static_cast<double>(s.lumps);
    sum_.crumbs += static_cast<double>(s.crumbs);
    if (sum_.stages.empty()) sum_.stages = std::vector<clay::Stage>(s.stages.size());
    for (std::size_t k = 0; k < s.stages.size(); ++k) {
      sum_.stages[k].name = s.stages[k].name;
      sum_.stages[k].ms += s.stages[k].ms;
    }
  }

  Stretch of(const clay::Clay& clay, double dropped) const {
    const auto frames = static_cast<double>(ms_.size()),
               particles = static_cast<double>(clay.particles().size());
    Stretch s = sum_;
    for (double* value :
         {&s.cpu_ms, &s.touched, &s.awake, &s.contacts, &s.iterations, &s.rounds, &s.lumps, &s.crumbs})
      *value /= frames;
    for (clay::Stage& stage : s.stages) stage.ms /= frames;
    s.end = clay.time();
    s.ms = quantile(ms_, 0.5);
    s.ms_p99 = quantile(ms_, 0.99);
    s.dropped = dropped;
    s.bonds = static_cast<double>(clay.statistics().bonds) / particles;
    s.neighbours = neighboursOf(clay);
    s.volume = volumeOf(clay.particles().position, clay.config().spacing);
    s.strays = clay.statistics().strays;
    s.memory = residentMegabytes();
    return s;
  }

 private:
  std::vector<double> ms_;
  Stretch sum_;
};

/// The first second of a run, to be played again and again.
class Yardstick {
 public:
  explicit Yardstick(const scene::Scene& scene)
      : clay_(scene.config, scene.materials, scene.particles), start_(clay_.sculpture()) {}

  /// @return median ms per frame
  double measure(const scene::Solids& solids, const std::vector<HandSample>& samples) {
    constexpr std::size_t frames = 60;
    clay_.restore(start_);
    std::vector<double> ms;
    for (std::size_t k = 0; k < frames; ++k) {
      const HandSample& sample = samples[k % samples.size()];
      const Clock::time_point begun = Clock::now();
      clay_.advance(sample.skin, solids.solids(), solids.motion(), sample.duration);
      ms.push_back(1e3 * Seconds(Clock::now() - begun).count());
    }
    return quantile(ms, 0.5);
  }

 private:
  clay::Clay clay_;
  clay::Sculpture start_;
};

}  // namespace

void kneadLong(const scene::Scene& scene, const scene::Solids& solids, const std::vector<HandSample>& samples,
               const LongKneading& how, const std::function<void(const Stretch&)>& tell) {
  if (samples.empty()) throw std::invalid_argument("long kneading: no hand sample, expected at least one");
  clay::Clay clay(scene.config, scene.materials, scene.particles);
  clay::LivePace pace(scene.config.frame, scene.config.timeStep());
  Yardstick yardstick(scene);
  Sums sums;
  LiveClock clock(how.slowness);
  clay::SkinPath path;
  double due = 0.0, before = 0.0, next_stretch = how.stretch;  // s; `due`: when the next sample comes
  std::size_t next = 0;
  while (clay.time() < how.duration) {
    const HandSample* sample = &samples[next++ % samples.size()];
    double duration = sample->duration;
    Skin skin = sample->skin;
    if (how.live) {
      due += duration;
      path.add(skin, due);
      // A late frame ends at the newest sample.
      while (clock.now() > due + samples[next % samples.size()].duration) {
        sample = &samples[next++ % samples.size()];
        due += sample->duration;
        path.add(sample->skin, due);
      }
      clock.waitUntil(due);
      duration = pace.next(clock.now() - before);
      before = clock.now();
      skin = path.frame(duration);
    }
    const Clock::time_point begun = Clock::now();
    const std::clock_t cpu_begun = std::clock();
    clay.advance(skin, solids.solids(), solids.motion(), duration);
    const double took = Seconds(Clock::now() - begun).count();
    sums.add(clay, 1e3 * took, 1e3 * static_cast<double>(std::clock() - cpu_begun) / CLOCKS_PER_SEC);
    pace.took(duration, clock.computed(duration, took));
    if (clay.time() < next_stretch) continue;
    next_stretch += how.stretch;
    const double ended = clock.now();
    Stretch stretch = sums.of(clay, pace.takeDropped());
    stretch.yardstick_ms = yardstick.measure(solids, samples);
    tell(stretch);
    sums = Sums();
    clock.setAside(clock.now() - ended);
  }
}

}  // namespace tactile_clay::tools
