#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
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
#include "tools/modulation_way.h"
#include "tools/random_contact.h"
#include "tools/shape_error.h"
#include "tools/tool_arguments.h"
#include "ultrasound/modulation.h"

namespace {

constexpr char usage[] =
    R"(Measures how well each modulation renders contacts: the tables of doc/logbook/rendering.md.

  compare_modulation [step=5] [layout=usx] [samples=1600] [strength=0.03,...] [patterns=1,...]
                     [evaluations=40] [blur=0,...] [weights=0] [normals=0,...] [skin=0] [random=0]
                     RUN.bag...

Record each bag with `scripts/rig lockstep:=true record:=RUN.bag`. step=N: every N-th frame with a contact counts.
Fields are solved in all frames, as in the rig. random=N: N random contacts of fingertips and palms are compared, too.
They are the same on every computer. skin=1: all are measured by the radiation pressure on rigid skin at its angle to
the sound, not by that of the field without skin. normals=0,1: with 1 the field solver knows this angle.
)";

using namespace tactile_clay;
using tools::Array;
using tools::ModulationWay;
using tools::RefinedSkin;
using tools::Samples;
using ultrasound::Modulation;

/// Pose of the array in world, from the tf messages of the run.
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

Samples pressedOf(const Samples& samples) {
  Samples pressed;
  for (const auto& sample : samples)
    if (sample.pressure > 0.0f) pressed.push_back(sample);
  return pressed;
}

void compare(const std::string& file, std::size_t step, const Array& array, std::vector<ModulationWay> ways) {
  rosbag::Bag bag(file);
  const Eigen::Isometry3f to_array = arrayPose(bag, file).inverse().cast<float>();
  const std::string pressure = std::string("/") + nodes::topic::hands_pressure;
  const std::string skin_topic = std::string("/") + nodes::topic::hands_skin;
  rosbag::View view(bag, rosbag::TopicQuery(std::vector<std::string>{pressure, skin_topic}));
  nodes::CloudJoin join;
  std::size_t touched = 0, frames = 0, samples = 0;
  for (const rosbag::MessageInstance& message : view) {
    const auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
    if (!cloud) continue;
    const auto pair = message.getTopic() == skin_topic ? join.addSkin(cloud) : join.addContacts(cloud);
    if (!pair) continue;
    ++frames;
    const Samples pressed = pressedOf(nodes::pressureSamples(*pair->second));
    Samples all;
    if (!pressed.empty()) all = tools::facingSkin(pressed, nodes::pressureSkin(*pair->first), to_array);
    std::optional<RefinedSkin> skin;
    if (!pressed.empty() && touched++ % step == 0) {
      skin = tools::refined(all);
      samples += all.size();
    }
    for (ModulationWay& way : ways) renderFrame(array, pressed, all, skin ? &*skin : nullptr, way);
  }
  if (frames == 0)
    throw std::runtime_error(
        file +
        ": no message on /hands/pressure has the stamp of one on /hands/skin, expected a recorded run");
  const std::size_t counted = (touched + step - 1) / step;
  std::printf(
      "%s: %zu frames with a contact, on average %zu samples of the skin that faces the array, at most %.0f "
      "mm from the contact\n\n",
      file.c_str(), touched, samples / std::max<std::size_t>(counted, 1), 1e3 * tools::skin_around_contacts);
  printTable(ways);
}

/// The third frame of each contact counts, because fields are continued from the frame before.
void compareRandom(unsigned count, const Array& array, std::vector<ModulationWay> ways) {
  constexpr double step = 0.004;  // m, between samples
  constexpr int frames = 3;
  for (unsigned seed = 0; seed < count; ++seed) {
    const Samples all = tools::randomContact(seed, step), pressed = pressedOf(all);
    const RefinedSkin skin = tools::refined(all);
    for (ModulationWay& way : ways) {
      startAnew(way);
      for (int frame = 1; frame <= frames; ++frame)
        renderFrame(array, pressed, all, frame == frames ? &skin : nullptr, way);
    }
  }
  std::printf("%u random contacts\n\n", count);
  printTable(ways);
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
      throw std::runtime_error("'" + word + "': expected numbers, separated by commas");
    values.push_back(value);
  }
  if (values.empty()) throw std::runtime_error("'" + word + "': expected a number");
  return values;
}

/// Arguments key=value, and files.
struct Task {
  std::map<std::string, std::string> values = {{"step", "5"},         {"layout", "usx"}, {"samples", "1600"},
                                               {"strength", "0.03"},  {"patterns", "1"}, {"blur", "0"},
                                               {"evaluations", "40"}, {"weights", "0"},  {"random", "0"},
                                               {"normals", "0"},      {"skin", "0"}};
  std::vector<std::string> files;

  Task(int argc, char** argv) {
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      const std::size_t equals = word.find('=');
      const auto found = values.find(word.substr(0, equals));
      if (found == values.end() || equals == std::string::npos)
        files.push_back(word);
      else
        found->second = word.substr(equals + 1);
    }
    if (files.empty() && whole("random", 0) == 0)
      throw std::runtime_error("no run and no random contacts, expected RUN.bag... or random=N; see --help");
  }

  std::vector<double> list(const std::string& key) const {
    return numbers(key + "=" + values.at(key), values.at(key));
  }

  std::size_t whole(const std::string& key, double minimum) const {
    const double value = list(key).front();
    if (!(value >= minimum && value <= 1e6 && value == std::floor(value)))
      throw std::runtime_error("'" + key + "=" + values.at(key) + "': expected a whole number from " +
                               std::to_string(static_cast<int>(minimum)));
    return static_cast<std::size_t>(value);
  }
};

ModulationWay wayOf(const Task& task, Modulation modulation, const ultrasound::FieldSolverOptions& options,
                    bool normals) {
  ultrasound::FocalPointConfig config;
  config.modulation = modulation;
  config.field_samples = task.whole("samples", 1);
  config.field_weights = task.whole("weights", 0) > 0;
  config.field_normals = normals;
  char numbers[128];
  std::snprintf(numbers, sizeof numbers, ", strength %g, %d pattern%s, blur %g mm", options.strength,
                options.patterns, options.patterns == 1 ? "" : "s", 1e3 * options.blur);
  return tools::fieldWay(ultrasound::nameOf(modulation) + std::string(numbers) +
                             (config.field_weights ? ", weighted" : "") + (normals ? ", with normals" : ""),
                         options, config);
}

std::vector<ModulationWay> waysOf(const Task& task) {
  std::vector<ModulationWay> ways = {tools::pointsWay("AM, 8 points", Modulation::amplitude),
                                     tools::pointsWay("lateral, 8 points", Modulation::lateral),
                                     tools::pointsWay("circle, 8 points", Modulation::circle),
                                     tools::pointsWay("STM, 32 places", Modulation::spatiotemporal)};
  for (const Modulation modulation : {Modulation::field, Modulation::field_circle})
    for (const double strength : task.list("strength"))
      for (const double patterns : task.list("patterns"))
        for (const double blur : task.list("blur"))
          for (const double normals : task.list("normals")) {
            ultrasound::FieldSolverOptions options;
            options.strength = strength;
            options.patterns = static_cast<int>(patterns);
            options.blur = blur;
            options.evaluations = static_cast<int>(task.whole("evaluations", 1));
            options.validate();
            ways.push_back(wayOf(task, modulation, options, normals > 0.0));
          }
  return ways;
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runTool("compare_modulation", usage, argc, argv, [&] {
    const Task task(argc, argv);
    const Array array{ultrasound::arrayLayouts(task.values.at("layout")), {}, task.whole("skin", 0) > 0};
    std::vector<ModulationWay> ways = waysOf(task);
    for (ModulationWay& way : ways) way.renderer.setArray(ultrasound::ArrayReach(array.layout, array.air));
    for (const std::string& file : task.files) compare(file, task.whole("step", 1), array, ways);
    const std::size_t random = task.whole("random", 0);
    if (random > 0) compareRandom(static_cast<unsigned>(random), array, ways);
  });
}
