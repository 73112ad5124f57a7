#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "contact/pressure_field.h"
#include "nodes/cloud_join.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/topics.h"
#include "tools/facing_skin.h"
#include "tools/shape_error.h"
#include "tools/tool_arguments.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/focal_points.h"
#include "ultrasound/modulation.h"

namespace {

constexpr char usage[] =
    R"(How well modulations render the contacts of recorded runs, as the tables of doc/logbook/rendering.md:
  compare_modulation [step=5] [layout=usx] [samples=1600] [strength=0.03,...] [patterns=1,...]
  [evaluations=40] RUN.bag...
where each bag was written by `scripts/rig lockstep:=true record:=RUN.bag`. Every N-th frame that is
touched counts; fields are solved in all of them, as in the rig.
)";

using namespace tactile_clay;
using tools::Samples;
using tools::Skin;
using ultrasound::Modulation;

constexpr double am = 0.5;  // mean of (1 - cos) / 2: what AM leaves of the pressure

/// A way to render, with what it keeps from frame to frame and what came of it.
struct Way {
  std::string name;
  ultrasound::FocalPointConfig config;
  ultrasound::FieldSolverOptions options;
  ultrasound::FocalPointRenderer renderer;
  std::vector<ultrasound::Drive> before;
  std::vector<double> points, coverage, error, weighted, pressure, most, cost;
};

Way pointsWay(const std::string& name, Modulation modulation) {
  ultrasound::FocalPointConfig config;
  config.modulation = modulation;
  return {name, config, {}, ultrasound::FocalPointRenderer(config), {}, {}, {}, {}, {}, {}, {}, {}};
}

Way fieldWay(const std::string& name, std::size_t samples, double strength, int patterns, int evaluations) {
  Way way = pointsWay(name, Modulation::field);
  way.config.field_samples = samples;
  way.renderer.configure(way.config);
  way.options.strength = strength;
  way.options.patterns = patterns;
  way.options.evaluations = evaluations;
  way.options.phase_levels = 32;
  return way;
}

struct Array {
  ultrasound::ArrayLayout layout;
  ultrasound::Acoustics air;
};

/// Radiation pressure of the true field on the skin, averaged over a period.
/// \param amplitude highest of a transducer
std::vector<float> rendered(const Array& array, const Way& way,
                            const std::vector<ultrasound::FocalPoint>& points,
                            const std::vector<ultrasound::Drive>& field, const Skin& skin, float& amplitude) {
  std::vector<double> mean(skin.position.size(), 0.0);  // of squared amplitudes
  const auto add = [&](const ultrasound::Drive& drive, double power) {
    amplitude = std::max(amplitude, *std::max_element(drive.amplitude.begin(), drive.amplitude.end()));
    const auto at = ultrasound::pressuresAt(array.layout, array.air, drive, skin.position);
    for (std::size_t i = 0; i < at.size(); ++i) mean[i] += power * static_cast<double>(std::norm(at[i]));
  };
  if (way.config.modulation == Modulation::field) {
    for (const auto& drive : field) add(drive, am / static_cast<double>(field.size()));
  } else {
    ultrasound::PhaseSolverOptions options;
    options.phase_levels = 32;
    for (const auto& part : ultrasound::parts(ultrasound::period(points, way.config.modulation)))
      add(ultrasound::solvePhases(array.layout, array.air, part.points, options).drive, part.power);
  }
  std::vector<float> result;
  for (const double m : mean)
    result.push_back(static_cast<float>(ultrasound::radiationPressure(array.air, std::sqrt(m))));
  return result;
}

void frame(const Array& array, const Samples& pressed, const Samples& all, const Skin* skin, Way& way) {
  const bool field = way.config.modulation == Modulation::field;
  const auto points = way.renderer.render(field ? all : pressed);
  if (points.empty()) {
    way.before.clear();
    return;
  }
  if (field) {
    const auto start = std::chrono::steady_clock::now();
    way.before = ultrasound::solveField(array.layout, array.air, points, way.options, way.before).drives;
    way.cost.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  if (skin == nullptr) return;
  float amplitude = 0.0f;
  const auto had = rendered(array, way, points, way.before, *skin, amplitude);
  const float peak = *std::max_element(had.begin(), had.end());
  double force = 0.0, covered = 0.0, felt = 0.0;
  for (std::size_t i = 0; i < had.size(); ++i) {
    const double f = skin->pressure[i] * skin->area[i];
    force += f;
    felt += f * had[i];
    if (had[i] >= 0.25f * peak) covered += f;
  }
  way.points.push_back(static_cast<double>(points.size()));
  way.coverage.push_back(covered / force);
  way.error.push_back(tools::shapeError(*skin, had, false));
  way.weighted.push_back(tools::shapeError(*skin, had, true));
  way.pressure.push_back(felt / force);
  way.most.push_back(felt / force / std::pow(static_cast<double>(amplitude), 2));
}

/// Pose of the array in world, as the run tells it.
Eigen::Isometry3d arrayPose(const rosbag::Bag& bag, const std::string& file) {
  rosbag::View view(bag, rosbag::TopicQuery(std::vector<std::string>{"/tf_static", "/tf"}));
  for (const rosbag::MessageInstance& message : view) {
    const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
    if (!transforms) continue;
    for (const auto& transform : transforms->transforms) {
      if (nodes::frameName(transform.child_frame_id) != nodes::frame::array) continue;
      const auto& t = transform.transform.translation;
      const auto& q = transform.transform.rotation;
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.translation() << t.x, t.y, t.z;
      pose.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
      return pose;
    }
  }
  throw std::runtime_error(file + ": no transform of frame 'array' on /tf_static, expected a recorded run");
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         std::max(1.0, static_cast<double>(values.size()));
}

void compare(const std::string& file, std::size_t step, const Array& array, std::vector<Way> ways) {
  rosbag::Bag bag(file);
  const Eigen::Isometry3f to_array = arrayPose(bag, file).inverse().cast<float>();
  const std::string pressure = std::string("/") + nodes::topic::hands_pressure;
  const std::string skin_topic = std::string("/") + nodes::topic::hands_skin;
  rosbag::View view(bag, rosbag::TopicQuery(std::vector<std::string>{pressure, skin_topic}));
  for (Way& way : ways) way.renderer.setArray(ultrasound::ArrayReach(array.layout, array.air));
  nodes::CloudJoin join;
  std::size_t touched = 0, frames = 0, samples = 0;
  for (const rosbag::MessageInstance& message : view) {
    const auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
    if (!cloud) continue;
    const auto pair = message.getTopic() == skin_topic ? join.addSkin(cloud) : join.addContacts(cloud);
    if (!pair) continue;
    ++frames;
    Samples pressed;
    for (const auto& sample : nodes::pressureSamples(*pair->second))
      if (sample.pressure > 0.0f) pressed.push_back(sample);
    Samples all;
    if (!pressed.empty()) all = tools::facingSkin(pressed, nodes::pressureSkin(*pair->first), to_array);
    std::optional<Skin> skin;
    if (!pressed.empty() && touched++ % step == 0) {
      skin = tools::refined(all);
      samples += all.size();
    }
    for (Way& way : ways) frame(array, pressed, all, skin ? &*skin : nullptr, way);
  }
  if (frames == 0)
    throw std::runtime_error(file +
                             ": no /hands/pressure with a /hands/skin of its stamp, expected a recorded run");
  const std::size_t counted = (touched + step - 1) / step;
  std::printf(
      "%s, %zu touched frames, in the mean %zu samples of skin that faces the array within %.0f mm\n\n",
      file.c_str(), touched, samples / std::max<std::size_t>(counted, 1), 1e3 * tools::skin_around_contacts);
  std::printf(
      "| modulation | points | error %% | weighted error %% | pressure, Pa | at full drive, Pa | coverage %% "
      "| "
      "solver, ms: median, 90 %% |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (Way& way : ways) {
    std::printf("| %s | %.1f | %.1f | %.1f | %.2f | %.2f | %.0f | ", way.name.c_str(), mean(way.points),
                100 * mean(way.error), 100 * mean(way.weighted), mean(way.pressure), mean(way.most),
                100 * mean(way.coverage));
    if (way.cost.empty()) {
      std::printf("|\n");
      continue;
    }
    std::sort(way.cost.begin(), way.cost.end());
    const auto at = [&](double share) {
      return 1e3 * way.cost[static_cast<std::size_t>(share * static_cast<double>(way.cost.size() - 1))];
    };
    std::printf("%.2f, %.2f |\n", at(0.5), at(0.9));
  }
  std::printf("\n");
}

std::vector<double> numbers(const std::string& word, const std::string& list) {
  std::vector<double> values;
  std::istringstream in(list);
  for (std::string part; std::getline(in, part, ',');) {
    std::size_t end = 0;
    double value = 0.0;
    try {
      value = std::stod(part, &end);
    } catch (const std::exception&) {
      end = 0;
    }
    if (end == 0 || end != part.size() || !std::isfinite(value))
      throw std::runtime_error("'" + word + "': expected numbers with commas between them");
    values.push_back(value);
  }
  if (values.empty()) throw std::runtime_error("'" + word + "': expected a number");
  return values;
}

}  // namespace

int main(int argc, char** argv) {
  if (tactile_clay::tools::askedForHelp(argc, argv, usage)) return 0;
  try {
    std::size_t step = 5, samples = ultrasound::FocalPointConfig().field_samples;
    std::string layout = "usx";
    int evaluations = ultrasound::FieldSolverOptions().evaluations;
    std::vector<double> strengths = {ultrasound::FieldSolverOptions().strength}, patterns = {1.0};
    std::vector<std::string> files;
    const auto whole = [](const std::string& word, double value) {
      if (!(value >= 1.0 && value <= 1e6 && value == std::floor(value)))
        throw std::runtime_error("'" + word + "': expected a whole number from 1");
      return static_cast<std::size_t>(value);
    };
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      const std::size_t equals = word.find('=');
      const std::string key = word.substr(0, equals),
                        value = equals == std::string::npos ? "" : word.substr(equals + 1);
      if (key == "layout" && equals != std::string::npos)
        layout = value;
      else if (key == "step" && equals != std::string::npos)
        step = whole(word, numbers(word, value).front());
      else if (key == "samples" && equals != std::string::npos)
        samples = whole(word, numbers(word, value).front());
      else if (key == "evaluations" && equals != std::string::npos)
        evaluations = static_cast<int>(whole(word, numbers(word, value).front()));
      else if (key == "strength" && equals != std::string::npos)
        strengths = numbers(word, value);
      else if (key == "patterns" && equals != std::string::npos)
        patterns = numbers(word, value);
      else
        files.push_back(word);
    }
    if (files.empty())
      throw std::runtime_error(
          "expected: compare_modulation [step=N] [layout=NAME] [samples=N] [strength=X,...] [patterns=N,...] "
          "[evaluations=N] RUN.bag...");
    std::vector<Way> ways = {pointsWay("AM, 8 points", Modulation::amplitude),
                             pointsWay("lateral, 8 points", Modulation::lateral),
                             pointsWay("STM, 32 places", Modulation::spatiotemporal)};
    for (const double strength : strengths) {
      for (const double count : patterns) {
        char name[100];
        std::snprintf(name, sizeof name, "field, strength %g, %g pattern%s", strength, count,
                      count == 1.0 ? "" : "s");
        ways.push_back(
            fieldWay(name, samples, strength, static_cast<int>(whole("patterns", count)), evaluations));
      }
    }
    for (const std::string& file : files) compare(file, step, {ultrasound::arrayLayouts(layout), {}}, ways);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "compare_modulation: %s\n", error.what());
    return 1;
  }
}
