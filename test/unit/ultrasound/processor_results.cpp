// Compiled twice, in namespaces `ultrasound` and `ultrasound_plain`: see processor_test.cpp.
#include <random>

#include "ultrasound/field_solver.h"
#include "ultrasound/phase_solver.h"

std::vector<float> TACTILE_CLAY_RESULTS() {
  using namespace tactile_clay::ultrasound;
  const ArrayLayout layout = arrayLayout("autd3");
  std::mt19937 random(31);
  std::vector<float> results;
  for (int trial = 0; trial < 8; ++trial) {
    std::vector<FocalPoint> foci(static_cast<std::size_t>(3 * trial + 1));
    const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
    for (FocalPoint& focus : foci) {
      focus.position = {0.2 * uniform() - 0.1, 0.2 * uniform() - 0.1, 0.1 + 0.1 * uniform()};
      focus.intensity = uniform();
    }
    PhaseSolverOptions options;
    options.method = static_cast<PhaseMethod>(trial % 4);
    options.phase_levels = trial % 2 == 0 ? 32 : 0;
    options.phase_only = trial < 5;
    const PhaseSolution solution = solvePhases(layout, {}, foci, options);
    results.insert(results.end(), solution.drive.phase.begin(), solution.drive.phase.end());
    results.insert(results.end(), solution.drive.amplitude.begin(), solution.drive.amplitude.end());
    for (FocalPoint& focus : foci) focus.normal = {uniform() - 0.5, uniform() - 0.5, -uniform()};
    FieldSolverOptions field_options;
    field_options.patterns = trial % 2 == 0 ? 1 : 2;
    for (const Drive& drive : solveField(layout, {}, foci, field_options).drives)
      results.insert(results.end(), drive.phase.begin(), drive.phase.end());
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 100; ++i) {
      points.push_back(
          Eigen::Vector3d(0.3 * uniform() - 0.15, 0.3 * uniform() - 0.15, uniform()).cast<float>());
    }
    const std::vector<Eigen::Vector3f> normals(points.size(), Eigen::Vector3f(0.6f, 0.0f, -0.8f));
    for (const auto& here : {pressuresAt(layout, {}, solution.drive, points),
                             pressuresAt(layout, {}, solution.drive, points, normals)}) {
      for (const auto& p : here) {
        results.push_back(p.real());
        results.push_back(p.imag());
      }
    }
  }
  return results;
}
