// Coverage and error of the modulations on the contacts of recorded runs, as the table of doc/rendering.md:
//   compare_modulation [step=N] [layout=usx] RUN.bag...
// where each bag was written by `scripts/rig lockstep:=true record:=RUN.bag`. Every N-th frame that is
// touched counts.
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "nodes/conversions.h"
#include "nodes/topics.h"
#include "ultrasound/focal_points.h"
#include "ultrasound/modulation.h"

namespace {

using namespace tactile_clay;
using ultrasound::Modulation;
using Samples = std::vector<contact::PressureSample>;

struct Way {
  const char* name;
  Modulation modulation;
  bool weights;
};
constexpr Way ways[] = {{"AM, 8 points", Modulation::amplitude, true},
                        {"AM, without perceptual weights", Modulation::amplitude, false},
                        {"lateral, 8 points", Modulation::lateral, true},
                        {"STM, 32 places", Modulation::spatiotemporal, true}};

/// Means over the frames of a run.
struct Figures {
  double frames = 0.0, points = 0.0, coverage = 0.0, error = 0.0, weighted_error = 0.0, pressure = 0.0;
  double saturated = 0.0;
};

/// sqrt(1 - cos^2) of the angle between two fields: the relative RMS error that is left when the scale is the
/// best.
double shapeError(const Samples& samples, const std::vector<float>& rendered, bool weighted) {
  double both = 0.0, wanted = 0.0, had = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double w = samples[i].area * (weighted ? static_cast<double>(samples[i].weight) : 1.0);
    both += w * samples[i].pressure * rendered[i];
    wanted += w * samples[i].pressure * samples[i].pressure;
    had += w * rendered[i] * rendered[i];
  }
  if (!(wanted > 0.0 && had > 0.0)) return 1.0;
  return std::sqrt(std::max(0.0, 1.0 - both * both / (wanted * had)));
}

void add(const Samples& samples, const std::vector<ultrasound::FocalPoint>& points, const Way& way,
         const ultrasound::RenderReport& report, const ultrasound::ArrayLayout& layout,
         const ultrasound::Acoustics& air, Figures& figures) {
  std::vector<Eigen::Vector3f> skin;
  for (const auto& sample : samples) skin.push_back(sample.position);
  ultrasound::PhaseSolverOptions options;
  options.phase_levels = 32;
  const auto rendered =
      ultrasound::tactilePressure(layout, air, ultrasound::period(points, way.modulation), options, skin);
  const float peak = *std::max_element(rendered.begin(), rendered.end());
  double force = 0.0, covered = 0.0, felt = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double f = static_cast<double>(samples[i].pressure) * samples[i].area;
    force += f;
    felt += f * rendered[i];
    if (rendered[i] >= 0.25f * peak) covered += f;
  }
  figures.frames += 1.0;
  figures.points += static_cast<double>(points.size());
  figures.coverage += covered / force;
  figures.error += shapeError(samples, rendered, false);
  figures.weighted_error += shapeError(samples, rendered, true);
  figures.pressure += felt / force;
  figures.saturated += static_cast<double>(report.saturated_points) / static_cast<double>(points.size());
}

void compare(const std::string& file, std::size_t step, const ultrasound::ArrayLayout& layout) {
  const ultrasound::Acoustics air;
  rosbag::Bag bag(file);
  rosbag::View view(bag, rosbag::TopicQuery(std::string("/") + nodes::topic::hands_pressure));
  if (view.size() == 0)
    throw std::runtime_error(file + ": no messages on /hands/pressure, expected a recorded run");
  std::vector<ultrasound::FocalPointRenderer> renderers;
  for (const Way& way : ways) {
    ultrasound::FocalPointConfig config;
    config.modulation = way.modulation;
    config.perceptual_weights = way.weights;
    renderers.emplace_back(config).setArray(ultrasound::ArrayReach(layout, air));
  }
  std::vector<Figures> figures(std::size(ways));
  std::size_t touched = 0;
  for (const rosbag::MessageInstance& message : view) {
    const auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
    if (!cloud) continue;
    const Samples samples = nodes::pressureSamples(*cloud);
    const bool counts = !samples.empty() && touched++ % step == 0;
    for (std::size_t k = 0; k < std::size(ways); ++k) {
      const auto points = renderers[k].render(samples);
      if (counts && !points.empty())
        add(samples, points, ways[k], renderers[k].report(), layout, air, figures[k]);
    }
  }
  std::printf("%s, %zu touched frames\n\n", file.c_str(), touched);
  std::printf(
      "| modulation | points | coverage %% | error %% | weighted error %% | mean pressure Pa | saturated %% "
      "|\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- |\n");
  for (std::size_t k = 0; k < std::size(ways); ++k) {
    const Figures& f = figures[k];
    const double n = std::max(f.frames, 1.0);
    std::printf("| %s | %.1f | %.0f | %.0f | %.0f | %.1f | %.0f |\n", ways[k].name, f.points / n,
                100 * f.coverage / n, 100 * f.error / n, 100 * f.weighted_error / n, f.pressure / n,
                100 * f.saturated / n);
  }
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::size_t step = 5;
    std::string layout = "usx";
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word.rfind("step=", 0) == 0) {
        const int value = std::atoi(word.c_str() + 5);
        if (value < 1) throw std::runtime_error("'" + word + "': expected a whole number from 1");
        step = static_cast<std::size_t>(value);
      } else if (word.rfind("layout=", 0) == 0) {
        layout = word.substr(7);
      } else {
        files.push_back(word);
      }
    }
    if (files.empty())
      throw std::runtime_error("expected: compare_modulation [step=N] [layout=NAME] RUN.bag...");
    for (const std::string& file : files) compare(file, step, ultrasound::arrayLayouts(layout));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "compare_modulation: %s\n", error.what());
    return 1;
  }
}
