// What a budget buys: plays a scene, with or without a hand, over a grid of solver, substeps, iterations and
// particle spacing, headless and in lockstep, and tells the error of each against a converged reference.
//
//   speed_accuracy --help
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "clay/clay.h"
#include "scene/robot_model.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "tools/accuracy_report.h"
#include "tools/hand_samples.h"
#include "tools/outcome.h"
#include "tools/share_folder.h"
#include "tools/tool_arguments.h"

namespace {

using namespace tactile_clay;
using namespace tactile_clay::tools;

constexpr const char* usage = R"(usage: speed_accuracy [--OPTION VALUE]...

Plays a scene for every setting of a grid and compares it with a reference of many small steps. Prints a table in
markdown, writes CSV.

  --scene NAME         a scene of config/scenes, or a file                      [incline]
  --hands WHICH        none, knead, potter, press, or a Leap recording          [none]
                       (.ndjson or .ndjson.gz, placed by config/rig.yaml)
  --duration S         simulated time                     [the hand's; 1.2 without]
  --solver LIST        minimise, paper                            [minimise,paper]
  --substeps LIST      of a frame of 1/60 s                                [1,2,4]
  --iterations LIST    of a substep                                       [4,8,16]
  --also LIST          single settings beside the grid, as in paper:1x5     [none]
  --spacing LIST       m between particles; 0 is the scene's                   [0]
  --reference SETTING  the reference's step is half of this         [minimise:32x64]
                       It is played three times more with the clay a micrometre
                       aside, along x, y and z: no error can be smaller than what
                       that does.
  --threads N          of the clay                                             [2]
  --csv FILE           one line for each setting and reference              [none]
  --share FOLDER       that holds config/              [found from the program's place]

Columns of the table; errors are differences from the reference of the same spacing:
  ms a frame      wall time of the steps of 1/60 s, median and 99th percentile
  displacement    root mean square over the particles of their distance from the reference's, at the end, spacings
  height          of the highest particle over the solids below it, at the end, mm; and its error
  force           of the clay on each hand, or on the solids if there is none, means of 0.1 s: root mean square of
                  the error over that of the reference; nan if the reference touches nothing
  density         mean of max(rho / rho_0 - 1, 0) over particles and time
  volume          within the surface where the smoothed clay is half as dense, end over start - 1
)";

struct Options {
  std::string scene, hands, csv, share;
  double duration = 0.0;  // s; 0: the hand's
  int threads = 0;
  std::vector<double> spacings;  // m; 0: the scene's
  std::vector<clay::Budget> settings;
  clay::Budget reference;
};

// ---- Reading options

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, at);) parts.push_back(part);
  return parts;
}

int whole(const std::string& option, const std::string& text, int low, int high) {
  const double value = numberOf(option, text, low, high);
  if (value != std::floor(value)) fail(option + " '" + text + "': expected a whole number");
  return static_cast<int>(value);
}

clay::Budget settingOf(const std::string& option, const std::string& text) {
  const std::size_t colon = text.find(':'), cross = text.find('x', colon == std::string::npos ? 0 : colon);
  if (colon == std::string::npos || cross == std::string::npos)
    fail(option + " '" + text + "': expected SOLVER:SUBSTEPSxITERATIONS, as in paper:1x5");
  clay::Budget setting;
  setting.method = clay::methodNamed(text.substr(0, colon));
  setting.substeps = whole(option, text.substr(colon + 1, cross - colon - 1), 1, 10000);
  setting.iterations = whole(option, text.substr(cross + 1), 1, 10000);
  return setting;
}

Options optionsOf(int argc, char** argv) {
  std::map<std::string, std::string> given = {{"--scene", "incline"},
                                              {"--hands", "none"},
                                              {"--duration", "0"},
                                              {"--solver", "minimise,paper"},
                                              {"--substeps", "1,2,4"},
                                              {"--iterations", "4,8,16"},
                                              {"--also", ""},
                                              {"--spacing", "0"},
                                              {"--reference", "minimise:32x64"},
                                              {"--threads", "2"},
                                              {"--csv", ""},
                                              {"--share", ""}};
  for (int k = 1; k < argc; k += 2) {
    const auto option = given.find(argv[k]);
    if (option == given.end()) fail("unknown option '" + std::string(argv[k]) + "', see --help");
    if (k + 1 == argc || std::string(argv[k + 1]).rfind("--", 0) == 0)
      fail("option " + option->first + " has no value, see --help");
    option->second = argv[k + 1];
  }
  Options o;
  o.scene = given["--scene"], o.hands = given["--hands"], o.csv = given["--csv"];
  o.share = given["--share"].empty() ? shareFolder() : given["--share"];
  o.duration = numberOf("--duration", given["--duration"], 0.0, 3600.0);
  o.threads = whole("--threads", given["--threads"], 1, 1024);
  o.reference = settingOf("--reference", given["--reference"]);
  for (const std::string& s : split(given["--spacing"], ','))
    o.spacings.push_back(numberOf("--spacing", s, 0.0, 0.1));
  for (const std::string& solver : split(given["--solver"], ',')) {
    for (const std::string& substeps : split(given["--substeps"], ',')) {
      for (const std::string& iterations : split(given["--iterations"], ',')) {
        clay::Budget setting;
        setting.method = clay::methodNamed(solver);
        setting.substeps = whole("--substeps", substeps, 1, 10000);
        setting.iterations = whole("--iterations", iterations, 1, 10000);
        o.settings.push_back(setting);
      }
    }
  }
  for (const std::string& text : split(given["--also"], ',')) o.settings.push_back(settingOf("--also", text));
  if (o.settings.empty() || o.spacings.empty()) fail("no setting is given, expected at least one");
  return o;
}

// ---- Playing

std::ofstream openCsv(const std::string& path) {
  std::ofstream csv;
  if (path.empty()) return csv;
  csv.open(path);
  if (!csv) fail("--csv '" + path + "' cannot be written");
  writeCsvHead(csv);
  return csv;
}

/// The scene with its clay a micrometre aside along an axis.
scene::Scene aside(scene::Scene scene, int axis) {
  for (clay::InitialParticle& particle : scene.particles) particle.position[axis] += 1e-6f;
  return scene;
}

/// Plays every setting with particles of one spacing, m; 0: the scene's.
void runAt(double wanted_spacing, const Options& options, std::ofstream& csv) {
  const scene::Scene scene = scene::loadScene(options.scene, options.share, wanted_spacing);
  const scene::Solids solids(scene::loadRobotModel(scene.urdf), scene.motions);
  const double spacing = scene.config.spacing;
  const std::vector<HandSample> samples =
      handSamples(options.hands, options.duration, spacing, options.share);
  Played played{options.scene, options.hands, spacing, scene.particles.size()};
  for (const HandSample& sample : samples) played.duration += sample.duration;

  const auto outcomeOf = [&](const clay::Budget& setting, const scene::Scene& of) {
    std::fprintf(stderr, "speed_accuracy: %s %s:%dx%d at %g mm\n", options.scene.c_str(),
                 nameOf(setting.method).c_str(), setting.substeps, setting.iterations, 1e3 * spacing);
    return play(of, solids, samples, setting, options.threads);
  };
  clay::Budget halved = options.reference;
  halved.substeps *= 2;
  const Outcome coarse = outcomeOf(options.reference, scene), reference = outcomeOf(halved, scene);

  const auto tell = [&](const char* role, const clay::Budget& setting, const Outcome& outcome) {
    const Row row{role, setting, outcome, compare(outcome, reference, spacing)};
    printRow(row);
    if (csv.is_open()) writeCsvRow(csv, played, row);
    return row.errors;
  };
  printHead(played);
  std::vector<Errors> errors;
  for (const clay::Budget& setting : options.settings)
    errors.push_back(tell("setting", setting, outcomeOf(setting, scene)));
  Doubt doubt;
  doubt.step = tell("twice the step", options.reference, coarse);
  for (int axis = 0; axis < 3; ++axis)
    doubt.aside = greatest(doubt.aside, tell("1 µm aside", halved, outcomeOf(halved, aside(scene, axis))));
  tell("reference", halved, reference);
  std::printf("\n%s\n", convergence(doubt, errors).c_str());
  std::fflush(stdout);
}

void run(const Options& options) {
  std::ofstream csv = openCsv(options.csv);
  for (const double spacing : options.spacings) runAt(spacing, options, csv);
}

}  // namespace

int main(int argc, char** argv) {
  return runTool("speed_accuracy", usage, argc, argv, [&] { run(optionsOf(argc, argv)); });
}
