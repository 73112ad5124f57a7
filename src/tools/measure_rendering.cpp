#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "nodes/conversions.h"
#include "nodes/topics.h"
#include "tools/quantile.h"
#include "tools/tool_arguments.h"
#include "ultrasound/focal_points.h"
#include "ultrasound/focus_peak.h"
#include "ultrasound/phase_solver.h"

namespace {

constexpr char usage[] =
    R"(Measures how well the contacts of recorded runs are rendered: the tables of doc/logbook/rendering.md.

  measure_rendering [step=N] [full_scale_pressure=PA] [min_resolution=X] [side_lobe_floor=X] [peaks=0] RUN.bag...

Record each bag with `scripts/rig lockstep:=true record:=RUN.bag`. Times and pressures are those of every frame with a
contact. In every N-th of these frames the program searches the peak beside each focal point, uphill in the plane of
the point. The sound is that of the SonicSurface board with 32 levels of phase, summed in double precision.
)";

using namespace tactile_clay;
using namespace tactile_clay::ultrasound;
using tools::quantile;
using ultrasound::FocalPoint;  // not the message

struct Figures {
  std::size_t frames = 0, points = 0, saturated = 0, raised = 0, merged = 0;
  std::vector<double> pressure;   // Pa of clay
  std::vector<double> asked;      // Pa of clay with which one point, 0.2 m above the array, asks for as much
  std::vector<double> amplitude;  // Pa, of a point by its intensity
  std::vector<double> aside;      // m, from a point to its peak
  std::vector<double> rendering, phases, both;  // s

  void add(const Figures& other) {
    frames += other.frames;
    points += other.points;
    saturated += other.saturated;
    raised += other.raised;
    merged += other.merged;
    for (auto member : {&Figures::pressure, &Figures::asked, &Figures::amplitude, &Figures::aside,
                        &Figures::rendering, &Figures::phases, &Figures::both})
      (this->*member).insert((this->*member).end(), (other.*member).begin(), (other.*member).end());
  }
};

Figures measure(const std::string& file, std::size_t step, const FocalPointConfig& config,
                const PhaseSolverOptions& options) {
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::duration time) { return std::chrono::duration<double>(time).count(); };
  const Acoustics air;
  const ArrayLayout layout = arrayLayout("sonic_surface");
  const ArrayReach reach(layout, air);
  const double reference = std::pow(reach.amplitude({0.0, 0.0, 0.2}), 2);
  FocalPointRenderer renderer(config);
  renderer.setArray(reach);
  rosbag::Bag bag(file);
  rosbag::View view(bag, rosbag::TopicQuery(std::string("/") + nodes::topic::hands_pressure));
  if (view.size() == 0)
    throw std::runtime_error(file + ": no messages on /hands/pressure, expected a recorded run");
  Figures figures;
  for (const rosbag::MessageInstance& message : view) {
    const auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
    if (!cloud) continue;
    const std::vector<contact::PressureSample> samples = nodes::pressureSamples(*cloud);
    const auto start = Clock::now();
    const std::vector<FocalPoint> points = renderer.render(samples);
    const auto rendered = Clock::now();
    if (points.empty()) continue;
    const PhaseSolution solution = solvePhases(layout, air, points, options);
    const auto solved = Clock::now();
    figures.rendering.push_back(seconds(rendered - start));
    figures.phases.push_back(seconds(solved - rendered));
    figures.both.push_back(seconds(solved - start));
    figures.points += points.size();
    figures.saturated += renderer.report().saturated_points;
    figures.raised += renderer.report().raised_points;
    figures.merged += renderer.report().merged_points;
    const auto count = static_cast<double>(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double maximum = reach.amplitude(points[k].position);
      figures.pressure.push_back(points[k].pressure);
      figures.asked.push_back(points[k].pressure * count * reference / (maximum * maximum));
      figures.amplitude.push_back(points[k].intensity * maximum / std::sqrt(count));
    }
    if (figures.frames++ % step != 0) continue;
    const auto amplitude = [&](const Eigen::Vector3d& at) {
      return std::abs(pressureAt(layout, air, solution.drive, at));
    };
    for (const FocalPoint& point : points)
      figures.aside.push_back((peakNear(point.position, amplitude) - point.position).norm());
  }
  return figures;
}

void print(const std::string& name, const Figures& f) {
  const Acoustics air;
  const auto points = static_cast<double>(std::max<std::size_t>(f.points, 1));
  const auto near = std::count_if(f.aside.begin(), f.aside.end(), [](double x) { return x < 0.002; });
  const double amplitude = quantile(f.amplitude, 0.5);
  const auto share = [](double part, double whole) { return 100.0 * part / whole; };  // %
  const auto at = [](const std::vector<double>& values, double part, double unit) {
    return quantile(values, part) / unit;
  };
  constexpr double kilo = 1e3, milli = 1e-3, micro = 1e-6;
  std::printf("| %s | %zu | %zu |", name.c_str(), f.frames, f.points);
  std::printf(" %.0f, %.0f, %.0f |", at(f.pressure, 0.5, kilo), at(f.pressure, 0.95, kilo),
              at(f.pressure, 0.99, kilo));
  std::printf(" %.0f, %.0f, %.0f, %.0f |", at(f.asked, 0.5, kilo), at(f.asked, 0.9, kilo),
              at(f.asked, 0.95, kilo), at(f.asked, 0.99, kilo));
  std::printf(" %.1f | %.1f | %.0f |", share(static_cast<double>(f.saturated), points),
              share(static_cast<double>(f.raised), points), static_cast<double>(f.merged));
  std::printf(" %.0f Pa, %.0f dB, %.1f Pa |", amplitude, soundPressureLevel(amplitude),
              radiationPressure(air, amplitude));
  std::printf(
      " %zu | %.2f mm, %.2f %% |", f.aside.size(), at(f.aside, 0.5, milli),
      share(static_cast<double>(near), static_cast<double>(std::max<std::size_t>(f.aside.size(), 1))));
  std::printf(" %.0f, %.0f | %.0f, %.0f |\n", at(f.rendering, 0.5, micro), at(f.rendering, 0.9, micro),
              at(f.both, 0.5, micro), at(f.both, 0.9, micro));
}

bool option(const std::string& word, const char* name, double& value) {
  const std::string start = std::string(name) + "=";
  if (word.rfind(start, 0) != 0) return false;
  char* end = nullptr;
  value = std::strtod(word.c_str() + start.size(), &end);
  if (end == word.c_str() + start.size() || *end != '\0')
    throw std::runtime_error("'" + word + "': expected a number");
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  return tactile_clay::tools::runTool("measure_rendering", usage, argc, argv, [&] {
    double step = 10.0, peaks = 1.0;
    FocalPointConfig config;
    PhaseSolverOptions options;
    options.phase_levels = 32;
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (!option(word, "step", step) && !option(word, "peaks", peaks) &&
          !option(word, "full_scale_pressure", config.full_scale_pressure) &&
          !option(word, "min_resolution", config.min_resolution) &&
          !option(word, "side_lobe_floor", config.side_lobe_floor))
        files.push_back(word);
    }
    options.peaks = peaks != 0.0;
    if (files.empty() || !(step >= 1.0))
      throw std::runtime_error(
          "expected: measure_rendering [step=N] [PARAMETER=VALUE...] RUN.bag..., N from 1");
    std::printf(
        "| run | frames | points | pressure, kPa: median, 95 %%, 99 %% | asked, kPa: median, 90 %%, 95 %%, "
        "99 %% | "
        "saturated %% | raised %% | merged | median point | searched | peak aside: median, share within 2 mm "
        "| "
        "clustering and intensities, us: median, 90 %% | with phases, us: median, 90 %% |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
    Figures all;
    for (const std::string& file : files) {
      const Figures figures = measure(file, static_cast<std::size_t>(step), config, options);
      print(file.substr(file.rfind('/') + 1), figures);
      all.add(figures);
    }
    print("all", all);
  });
}
