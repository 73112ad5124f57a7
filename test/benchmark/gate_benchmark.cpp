#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "device/loudness_meter.h"
#include "device/safety_gate.h"
#include "spiral.h"
#include "tools/quantile.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::device {
namespace {

double median(const std::vector<double>& values) {
  return tools::quantile(values, 0.5);
}

/// Adds the processor time of f, of all threads, to `seconds`.
template <typename F>
auto timed(double& seconds, const F& f) {
  const std::clock_t start = std::clock();
  auto result = f();
  seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return result;
}

/// Samples of skin 5 mm apart, the inner half of them pressed.
std::vector<contact::PressureSample> skin(int count, float shift) {
  std::vector<contact::PressureSample> samples(static_cast<std::size_t>(count));
  for (int m = 0; m < count; ++m) {
    const Eigen::Vector2f at = onSpiral(m).cast<float>();
    const float share = static_cast<float>(m) / static_cast<float>(count);
    const float pressure = share < 0.5f ? 15000.0f * (1.0f - share) : 0.0f;
    samples[static_cast<std::size_t>(m)] = {
        {at.x() + shift, at.y(), 0.2f}, {0, 0, -1}, pressure, pressure * 2.5e-5f, 2.5e-5f, 1.0f};
  }
  return samples;
}

/// A frame of the gate for a field, and for the eight focal points (AM) of the same contact, in turns. The
/// skin moves by 1 mm a frame. Argument: samples. Counters: median processor time, us, of the frame of the
/// field, of its solver, of the search for the loudest place in it, and of the rest; of the frame with AM;
/// mean number of solutions in a frame of the field.
void gate(benchmark::State& state) {
  const auto layout = ultrasound::arrayLayout("usx");
  const ultrasound::Acoustics air;
  double solver = 0.0, search = 0.0, solves = 0.0;
  Instrument instrument;
  instrument.scalable = true;
  instrument.solve = [&](const auto& points, const auto*) {
    return ultrasound::solvePhases(layout, air, points, {});
  };
  instrument.solve_field = [&](const auto& targets, double amplitude, const auto& before, double) {
    ultrasound::FieldSolverOptions options;
    options.amplitude = amplitude;
    solves += 1.0;
    return timed(solver, [&] { return ultrasound::solveField(layout, air, targets, options, before); });
  };
  SafetyGateConfig config;
  config.head_spl_cap = 200.0;  // no limit, as for the simulated array
  const LoudnessMeter meter(layout, air, {0.0, -0.4, 0.3}, config);
  instrument.loudness = [&](const auto& drive, const auto& points) {
    return timed(search, [&] { return meter(drive, points); });
  };
  const auto renderer = [&](ultrasound::Modulation modulation) {
    ultrasound::FocalPointConfig how;
    how.modulation = modulation;
    ultrasound::FocalPointRenderer made(how);
    made.setArray(ultrasound::ArrayReach(layout, air));
    return made;
  };
  auto points = renderer(ultrasound::Modulation::amplitude), field = renderer(ultrasound::Modulation::field);
  SafetyGate with_points(config, instrument), with_field(config, instrument);
  with_points.start();
  with_field.start();
  std::vector<double> whole, of_solver, of_search, rest, am;
  int frame = 0;
  for (auto _ : state) {
    frame = (frame + 1) % 50;
    const auto samples =
        skin(static_cast<int>(state.range(0)), 0.001f * static_cast<float>(std::min(frame, 50 - frame)));
    const Emission shape{field.render(samples), 200.0, ultrasound::Modulation::field};
    const Emission foci{points.render(samples), 200.0, ultrasound::Modulation::amplitude};
    const Occasion now{0.0, 1.0 / 60.0};
    double seconds = solver = search = 0.0;
    if (!timed(seconds, [&] { return with_field.check(shape, now); }).passes())
      state.SkipWithError("the field does not pass");
    whole.push_back(seconds);
    of_solver.push_back(solver);
    of_search.push_back(search);
    rest.push_back(seconds - solver - search);
    seconds = 0.0;
    if (!timed(seconds, [&] { return with_points.check(foci, now); }).passes())
      state.SkipWithError("the points do not pass");
    am.push_back(seconds);
  }
  state.counters["solves"] = solves / static_cast<double>(state.iterations());
  state.counters["field_us"] = 1e6 * median(whole);
  state.counters["solver_us"] = 1e6 * median(of_solver);
  state.counters["search_us"] = 1e6 * median(of_search);
  state.counters["rest_us"] = 1e6 * median(rest);
  state.counters["am_us"] = 1e6 * median(am);
}
BENCHMARK(gate)->ArgName("samples")->Arg(200)->Arg(600)->Arg(1400)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tactile_clay::device

BENCHMARK_MAIN();
