#include "tools/long_kneading.h"

#include <unistd.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "clay/live_pace.h"
#include "clay/neighbourhood.h"
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

/// Sums of the frames of a stretch.
class Sums {
 public:
  void add(const clay::Statistics& s, double ms, double cpu_ms) {
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
    for (double* value : {&s.cpu_ms, &s.awake, &s.contacts, &s.iterations, &s.rounds, &s.lumps, &s.crumbs})
      *value /= frames;
    for (clay::Stage& stage : s.stages) stage.ms /= frames;
    s.end = clay.time();
    s.ms = quantile(ms_, 0.5), s.ms_p99 = quantile(ms_, 0.99);
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
  Yardstick(const scene::Scene& scene, const scene::Solids& solids, const std::vector<HandSample>& samples)
      : solids_(solids), samples_(samples), clay_(scene.config, scene.materials, scene.particles) {
    start_ = clay_.sculpture();
  }

  /// \return ms of a frame, median
  double measure() {
    constexpr std::size_t frames = 60;
    clay_.restore(start_);
    std::vector<double> ms;
    for (std::size_t k = 0; k < frames; ++k) {
      const HandSample& sample = samples_[k % samples_.size()];
      const Clock::time_point begun = Clock::now();
      clay_.advance(sample.skin, solids_.solids(), solids_.motion(), sample.duration);
      ms.push_back(1e3 * Seconds(Clock::now() - begun).count());
    }
    return quantile(ms, 0.5);
  }

 private:
  const scene::Solids& solids_;
  const std::vector<HandSample>& samples_;
  clay::Clay clay_;
  clay::Sculpture start_;
};

}  // namespace

void kneadLong(const scene::Scene& scene, const scene::Solids& solids, const std::vector<HandSample>& samples,
               const LongKneading& how, const std::function<void(const Stretch&)>& tell) {
  if (samples.empty()) throw std::invalid_argument("long kneading: no hand sample, expected one at least");
  clay::Clay clay(scene.config, scene.materials, scene.particles);
  clay::LivePace pace(scene.config.frame, scene.config.timeStep());
  Yardstick yardstick(scene, solids, samples);
  Sums sums;
  double due = 0.0, next_stretch = how.stretch;  // s; when the next sample comes, since the start
  Clock::time_point before = Clock::now();
  Clock::time_point start = before;
  for (std::size_t k = 0; clay.time() < how.duration; ++k) {
    const HandSample* sample = &samples[k % samples.size()];
    due += sample->duration;
    double duration = sample->duration;
    if (how.live) {
      // A late frame takes the newest sample, as a subscriber with a queue of one does.
      while (Seconds(Clock::now() - start).count() > due + samples[(k + 1) % samples.size()].duration) {
        sample = &samples[++k % samples.size()];
        due += sample->duration;
      }
      std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(Seconds(due)));
      duration = pace.next(Seconds(Clock::now() - before).count());
      before = Clock::now();
    }
    const Clock::time_point begun = Clock::now();
    const std::clock_t cpu_begun = std::clock();
    clay.advance(sample->skin, solids.solids(), solids.motion(), duration);
    const double took = Seconds(Clock::now() - begun).count();
    pace.took(duration, took);
    sums.add(clay.statistics(), 1e3 * took,
             1e3 * static_cast<double>(std::clock() - cpu_begun) / CLOCKS_PER_SEC);
    if (clay.time() < next_stretch) continue;
    next_stretch += how.stretch;
    const Clock::time_point ended = Clock::now();
    Stretch stretch = sums.of(clay, pace.takeDropped());
    stretch.yardstick_ms = yardstick.measure();
    tell(stretch);
    sums = Sums();
    const Clock::duration aside = Clock::now() - ended;  // is no part of the run
    before += aside;
    start += aside;
  }
}

}  // namespace tactile_clay::tools
