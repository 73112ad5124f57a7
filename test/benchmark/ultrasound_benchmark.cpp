#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "float_propagator.h"
#include "spiral.h"
#include "tools/quantile.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/fixed_propagator.h"
#include "ultrasound/focal_points.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound {
namespace {

std::vector<FocalPoint> randomFoci(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  std::vector<FocalPoint> foci;
  while (foci.size() < count) {
    FocalPoint next;
    next.position = {place(random), place(random), 0.18 + 0.4 * place(random)};
    next.intensity = 1.0;
    bool free = true;
    for (const auto& f : foci) free = free && (f.position - next.position).norm() > 0.012;
    if (free) foci.push_back(next);
  }
  return foci;
}

/// A pressed palm at 5 mm between samples: 40 mm in radius, some 200 samples.
std::vector<contact::PressureSample> palm(float shift) {
  std::vector<contact::PressureSample> samples;
  for (int i = -8; i <= 8; ++i) {
    for (int j = -8; j <= 8; ++j) {
      const float d = 0.005f * std::hypot(static_cast<float>(i), static_cast<float>(j));
      if (d > 0.04f) continue;
      const float pressure = 5000.0f * (1.0f - 10.0f * d);
      samples.push_back({{0.005f * static_cast<float>(i) + shift, 0.005f * static_cast<float>(j), 0.2f},
                         {0, 0, -1},
                         pressure,
                         pressure * 2.5e-5f,
                         2.5e-5f,
                         1.0f});
    }
  }
  return samples;
}

/// Seconds of every frame, for their median: a mean would count what else the machine does.
class Times {
 public:
  template <typename F>
  void measure(F&& f) {
    const auto start = std::chrono::steady_clock::now();
    f();
    add(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  void add(double value) { seconds_.push_back(value); }
  double median() const { return tools::quantile(seconds_, 0.5); }

 private:
  std::vector<double> seconds_;
};

struct Case {
  PhaseMethod method;
  int iterations;
  bool peaks;
  double attenuation;  // Np/m
};
constexpr Case cases[] = {{PhaseMethod::naive, 1, false, 0.0},
                          {PhaseMethod::weighted_gerchberg_saxton, 20, false, 0.0},
                          {PhaseMethod::weighted_gerchberg_saxton, 100, false, 0.0},
                          {PhaseMethod::gs_pat, 100, false, 0.0},
                          {PhaseMethod::newton, 5, false, 0.0},
                          {PhaseMethod::newton, 5, true, 0.0},
                          {PhaseMethod::newton, 5, true, 0.15}};
constexpr std::size_t trials = 100;

/// Arguments: case, foci, steps of a turn (0: any phase), 1 for unequal foci (intensities 0.3 to 1).
/// Counters: median time, us; over 100 sets of random foci the mean relative RMS error of their amplitudes
/// about their common scale, %, and its worst set; their mean pressure, Pa. The field is the direct sum in
/// double precision, with the phases of the drive.
void phases(benchmark::State& state) {
  const ArrayLayout layout = arrayLayout("usx");
  Acoustics air;
  const Case& c = cases[state.range(0)];
  air.attenuation = c.attenuation;
  PhaseSolverOptions options;
  options.method = c.method;
  options.iterations = c.iterations;
  options.peaks = c.peaks;
  options.phase_levels = static_cast<int>(state.range(2));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> intensity(0.3, 1.0);
  std::vector<std::vector<FocalPoint>> sets;
  for (std::size_t t = 0; t < trials; ++t) {
    sets.push_back(randomFoci(static_cast<std::size_t>(state.range(1)), random));
    if (state.range(3) == 0) continue;
    for (auto& focus : sets.back()) focus.intensity = intensity(random);
  }
  std::size_t next = 0;
  Times times;
  for (auto _ : state) {
    times.measure(
        [&] { benchmark::DoNotOptimize(solvePhases(layout, air, sets[next++ % trials], options)); });
  }
  double error = 0.0;
  double worst = 0.0;
  double pressure = 0.0;
  for (const auto& foci : sets) {
    const PhaseSolution solution = solvePhases(layout, air, foci, options);
    const auto m = static_cast<double>(foci.size());
    std::vector<double> share;
    double mean = 0.0;
    for (std::size_t k = 0; k < foci.size(); ++k) {
      const double p = std::abs(pressureAt(layout, air, solution.drive, foci[k].position));
      share.push_back(p / solution.target[k]);
      mean += share.back() / m;
      pressure += p / m / trials;
    }
    double square = 0.0;
    for (const double x : share) square += std::pow(x / mean - 1.0, 2);
    error += std::sqrt(square / m) / trials;
    worst = std::max(worst, std::sqrt(square / m));
  }
  state.counters["median_us"] = 1e6 * times.median();
  state.counters["error_percent"] = 100.0 * error;
  state.counters["worst_percent"] = 100.0 * worst;
  state.counters["mean_Pa"] = pressure;
  constexpr const char* names[] = {"naive", "weighted_gerchberg_saxton", "gs_pat", "newton"};
  state.SetLabel(std::string(names[static_cast<int>(c.method)]) + ", " + std::to_string(c.iterations) +
                 (c.peaks ? ", peaks" : "") + (c.attenuation > 0.0 ? ", air takes 0.15 Np/m" : ""));
}
BENCHMARK(phases)
    ->ArgNames({"case", "foci", "levels", "unequal"})
    ->ArgsProduct({{0, 1, 2, 3, 4, 5, 6}, {1, 2, 4, 8, 16}, {0, 32}, {0, 1}})
    ->Unit(benchmark::kMicrosecond);

/// Argument: points of the slice or skin. Time: of the clock, on all cores; CPU: of all threads together.
void field(benchmark::State& state) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  std::mt19937 random(1);
  const Drive drive = solvePhases(layout, air, randomFoci(4, random)).drive;
  std::uniform_real_distribution<float> place(-0.1f, 0.1f);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < state.range(0); ++i)
    points.emplace_back(place(random), place(random), 0.2f + place(random));
  for (auto _ : state) benchmark::DoNotOptimize(pressuresAt(layout, air, drive, points));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(field)
    ->Arg(16)
    ->Arg(1700)
    ->Arg(4096)
    ->Arg(1000000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

/// A palm of 200 samples that moves by 1 mm a frame. Argument: max_points. Counters: median time of
/// clustering and intensities, and of these with the phases on 32 levels, us.
void frame(benchmark::State& state) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  FocalPointConfig config;
  config.max_points = static_cast<std::size_t>(state.range(0));
  FocalPointRenderer renderer(config);
  renderer.setArray(ArrayReach(layout, air));
  PhaseSolverOptions options;
  options.phase_levels = 32;
  std::vector<FocalPoint> points;
  std::vector<std::vector<contact::PressureSample>> palms;
  for (int i = 0; i < 50; ++i) palms.push_back(palm(0.001f * static_cast<float>(i < 25 ? i : 50 - i)));
  renderer.render(palms[0]);
  std::size_t next = 0;
  Times rendering;
  Times whole;
  for (auto _ : state) {
    const auto& samples = palms[next++ % palms.size()];
    whole.measure([&] {
      rendering.measure([&] { points = renderer.render(samples); });
      benchmark::DoNotOptimize(solvePhases(layout, air, points, options));
    });
  }
  state.counters["foci"] = static_cast<double>(points.size());
  state.counters["rendering_us"] = 1e6 * rendering.median();
  state.counters["with_phases_us"] = 1e6 * whole.median();
}
BENCHMARK(frame)->ArgName("foci")->Arg(1)->Arg(8)->Arg(16)->Unit(benchmark::kMicrosecond);

/// The phases of all transducers for the pressure on samples of skin at an angle of 17 degrees to the array,
/// half of them pressed, that move by 1 mm a frame. Arguments: samples, patterns. Counters: median time of a
/// frame, us; mean error, %.
void patterns(benchmark::State& state) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  FieldSolverOptions options;
  options.patterns = static_cast<int>(state.range(1));
  options.phase_levels = 32;
  const auto count = static_cast<int>(state.range(0));
  std::vector<std::vector<FocalPoint>> frames;
  for (int frame = 0; frame < 50; ++frame) {
    const double shift = 0.001 * (frame < 25 ? frame : 50 - frame);
    std::vector<FocalPoint> targets(static_cast<std::size_t>(count));
    for (int m = 0; m < count; ++m) {
      targets[m].position << onSpiral(m) + Eigen::Vector2d(shift, 0.0), 0.2;
      targets[m].normal = {0.3, 0.0, -1.0};
      targets[m].intensity = 2 * m < count ? 0.2 * (1.0 - m / static_cast<double>(count)) : 0.0;
    }
    frames.push_back(targets);
  }
  std::vector<Drive> before = solveField(layout, air, frames.front(), options).drives;
  std::size_t next = 0;
  double error = 0.0;
  Times times;
  for (auto _ : state) {
    FieldSolution solution;
    times.measure(
        [&] { solution = solveField(layout, air, frames[next++ % frames.size()], options, before); });
    before = std::move(solution.drives);
    error += solution.error;
  }
  state.counters["median_us"] = 1e6 * times.median();
  state.counters["error_percent"] = 100.0 * error / static_cast<double>(state.iterations());
}
BENCHMARK(patterns)
    ->ArgNames({"samples", "patterns"})
    ->Args({200, 1})
    ->Args({600, 1})
    ->Args({1400, 1})
    ->Args({200, 4})
    ->Unit(benchmark::kMicrosecond);

/// What a frame of a field spends on the propagator: it is filled once and used in 40 evaluations with their
/// gradients. Whole numbers of sixteen bits (FixedPropagator) and floats take turns. Argument: samples.
/// Counters: median processor time of a frame with each, us; the median of their ratio in a turn.
void propagator(benchmark::State& state) {
  const auto rows = static_cast<std::size_t>(state.range(0));
  constexpr std::size_t width = lanesFor(256);
  constexpr int evaluations = 40;
  LaneArray<ComplexLanes> row(width), q(width), z(width);
  for (std::size_t i = 0; i < width; ++i) {
    unitCircle(Lanes{} + 0.618034f * static_cast<float>(i), row[i].re, row[i].im);
    unitCircle(Lanes{} + 0.754878f * static_cast<float>(i), q[i].re, q[i].im);
  }
  std::vector<float> re(rows), im(rows);
  const auto frame = [&](auto& g, const auto& set_row) {
    const std::clock_t start = std::clock();
    for (std::size_t m = 0; m < rows; ++m) set_row(m);
    for (int i = 0; i < evaluations; ++i) {
      g.pressures(q.data(), re.data(), im.data());
      g.transposed(re.data(), im.data(), z.data());
      benchmark::DoNotOptimize(z.data());
      benchmark::ClobberMemory();
    }
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  FixedPropagator fixed(rows, width);
  FloatPropagator floats(rows, width);
  constexpr auto reach = static_cast<float>(width * wide_lane_count);
  Times whole, single, ratio;
  for (auto _ : state) {
    const double with_fixed = frame(fixed, [&](std::size_t m) { fixed.setRow(m, row.data(), reach); });
    const double with_floats = frame(floats, [&](std::size_t m) { floats.setRow(m, row.data()); });
    whole.add(with_fixed);
    single.add(with_floats);
    ratio.add(with_floats / with_fixed);
  }
  state.counters["fixed_us"] = 1e6 * whole.median();
  state.counters["float_us"] = 1e6 * single.median();
  state.counters["float_over_fixed"] = ratio.median();
}
BENCHMARK(propagator)->ArgName("samples")->Arg(200)->Arg(600)->Arg(1400)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tactile_clay::ultrasound

BENCHMARK_MAIN();
