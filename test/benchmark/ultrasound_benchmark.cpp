#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

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

/// Arguments: foci, iterations. Counter: RMS error of the foci's amplitudes, %.
void solve(benchmark::State& state) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  std::mt19937 random(1);
  const auto foci = randomFoci(static_cast<std::size_t>(state.range(0)), random);
  PhaseSolverOptions options;
  options.iterations = static_cast<int>(state.range(1));
  PhaseSolution solution;
  for (auto _ : state) {
    solution = solvePhases(layout, air, foci, options);
    benchmark::DoNotOptimize(solution);
  }
  double mean = 0.0;
  double square = 0.0;
  const auto m = static_cast<double>(foci.size());
  for (std::size_t k = 0; k < foci.size(); ++k) mean += solution.reached[k] / solution.target[k] / m;
  for (std::size_t k = 0; k < foci.size(); ++k) {
    square += std::pow(solution.reached[k] / solution.target[k] / mean - 1.0, 2);
  }
  state.counters["error_percent"] = 100.0 * std::sqrt(square / m);
}
BENCHMARK(solve)->ArgsProduct({{1, 2, 4, 8, 16}, {20, 100}})->Unit(benchmark::kMicrosecond);

/// Argument: points of the slice or skin.
void field(benchmark::State& state) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  std::mt19937 random(1);
  const Drive drive = solvePhases(layout, air, randomFoci(4, random)).drive;
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < state.range(0); ++i) points.emplace_back(1e-5f * static_cast<float>(i), 0.01f, 0.2f);
  for (auto _ : state) benchmark::DoNotOptimize(pressuresAt(layout, air, drive, points));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(field)->Arg(16)->Arg(1700)->Arg(4096)->Unit(benchmark::kMicrosecond)->UseRealTime();

/// Argument: max_points.
void render(benchmark::State& state) {
  FocalPointConfig config;
  config.max_points = static_cast<std::size_t>(state.range(0));
  FocalPointRenderer renderer(config);
  int frame = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(renderer.render(palm(0.001f * static_cast<float>(frame++ % 50))));
}
BENCHMARK(render)->Arg(1)->Arg(8)->Arg(16)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tactile_clay::ultrasound

BENCHMARK_MAIN();
