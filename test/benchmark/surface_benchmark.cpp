// What the surface of the clay costs, in one thread: a turned cylinder of clay (4 169 particles, as the scene
// potters_wheel) and a cube, both with particles that do not stand on a lattice any more.
// Quote medians: --benchmark_repetitions=5 --benchmark_report_aggregates_only=true.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "scene/scene.h"
#include "surface/clay_surface.h"

namespace {

using namespace tactile_clay;
using Eigen::Vector3f;

constexpr float spacing = 0.005f;  // m

void stir(std::vector<Vector3f>& points) {
  std::mt19937 random(1);
  std::normal_distribution<float> jitter(0.0f, 0.1f * spacing);
  for (Vector3f& p : points) p += Vector3f(jitter(random), jitter(random), jitter(random));
}

void run(benchmark::State& state, std::vector<Vector3f> points) {
  stir(points);
  clay::VectorField position;
  position.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) position.set(i, points[i]);
  const std::vector<Vector3f> color(points.size(), Vector3f(0.7f, 0.5f, 0.3f));
  surface::ClaySurface surface(spacing);
  for (auto _ : state) benchmark::DoNotOptimize(surface.update(position, color));
  state.counters["triangles"] = static_cast<double>(surface.update(position, color).triangles.size());
}

void wheel(benchmark::State& state) {
  std::vector<Vector3f> points;
  for (const auto& particle : scene::loadScene("potters_wheel", TACTILE_CLAY_SHARE).particles)
    points.push_back(particle.position);
  run(state, points);
}

void cube(benchmark::State& state) {
  const int count = static_cast<int>(state.range(0)), side = static_cast<int>(std::ceil(std::cbrt(count)));
  std::vector<Vector3f> points;
  for (int i = 0; i < count; ++i)
    points.push_back(spacing * Eigen::Vector3i(i % side, i / side % side, i / (side * side)).cast<float>());
  run(state, points);
}

BENCHMARK(wheel)->Unit(benchmark::kMillisecond)->Name("surface/4169");
BENCHMARK(cube)->Unit(benchmark::kMillisecond)->Name("surface")->Arg(20000)->Arg(100000);

}  // namespace

BENCHMARK_MAIN();
