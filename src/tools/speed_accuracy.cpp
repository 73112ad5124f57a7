// What a budget buys: plays a scene, with or without a hand, over a grid of solver, substeps, iterations and
// particle spacing, headless and in lockstep, and tells the error of each against a converged reference.
//
//   speed_accuracy --help
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "clay/clay.h"
#include "scene/robot_model.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "tools/accuracy_report.h"
#include "tools/hand_samples.h"
#include "tools/outcome.h"
#include "tools/outcome_file.h"
#include "tools/rig_pose.h"
#include "tools/share_folder.h"
#include "tools/tool_arguments.h"
#include "ultrasound/field_solver.h"

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
  --material LIST      of all bodies, as putty,hard_wax                 [the scene's]
  --hand LIST          kinematic, soft                                    [kinematic]
  --skin LIST          m between samples of the hands' skin; 0 is the spacing  [0]
  --render LIST        pressure on the skin as focal points or as a field, as in
                       points:4,points:8,field:1 (patterns)                    [none]
  --reference SETTING  the reference's step is half of this         [minimise:32x64]
                       It is played three times more with the clay a micrometre
                       aside, along x, y and z: no error can be smaller than what
                       that does.
  --threads N          of the clay                                             [2]
  --csv FILE           one line for each setting and reference              [none]
  --outcomes FOLDER    keeps what was played there, and plays nothing again that is
                       there: a sweep that was stopped goes on             [none]
  --shard I/N          plays a share of the sweep into --outcomes, and prints no
                       table: I of N computers                              [1/1]
  --merge yes|no       plays nothing: the table is of --outcomes             [no]
  --share FOLDER       that holds config/              [found from the program's place]

Each spacing, material and hand has a reference of its own, with the finest skin of the list. Columns of the table;
errors are differences from that reference:
  ms a frame      wall time of the steps of 1/60 s, median and 99th percentile
  displacement    root mean square over the particles of their distance from the reference's, at the end, spacings
  height          of the highest particle over the solids below it, at the end, mm; and its error
  force           of the clay on each hand, or on the solids if there is none, means of 0.1 s: root mean square of
                  the error over that of the reference; nan if the reference touches nothing
  density         mean of max(rho / rho_0 - 1, 0) over particles and time
  pressure        of what the array renders on the skin (--render, layout usx): root mean square error over what
                  the clay presses there, at the best common scale, ten times a second; and ms that it took
  volume          within the surface where the smoothed clay is half as dense, end over start - 1
)";

struct Options {
  std::string scene, hands, csv, share, outcomes;
  int shard = 1, shards = 1;
  bool merge = false;
  double duration = 0.0;  // s; 0: the hand's
  int threads = 0;
  std::vector<double> spacings;                // m; 0: the scene's
  std::vector<std::string> materials, models;  // of all bodies, and of hands; "": the scene's
  std::vector<double> skins;                   // m; 0: the spacing
  std::vector<Rendering> renderings;
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

/// Which part of the sweep is played here.
void readShare(std::map<std::string, std::string>& given, Options& o) {
  const std::string& shard = given["--shard"];
  const std::size_t slash = shard.find('/');
  if (slash == std::string::npos) fail("--shard '" + shard + "': expected I/N, as in 2/8");
  o.shards = whole("--shard", shard.substr(slash + 1), 1, 10000);
  o.shard = whole("--shard", shard.substr(0, slash), 1, o.shards);
  if (given["--merge"] != "yes" && given["--merge"] != "no")
    fail("--merge '" + given["--merge"] + "': expected yes or no");
  o.merge = given["--merge"] == "yes";
  if (o.outcomes.empty() && (o.shards > 1 || o.merge)) fail("--shard and --merge need a folder: --outcomes");
  if (o.shards > 1 && o.merge) fail("--shard and --merge: expected one of them");
}

Rendering renderingOf(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  if (colon == std::string::npos || (kind != "points" && kind != "field"))
    fail("--render '" + text + "': expected points:N or field:N, as in points:8");
  const Rendering rendering{kind == "field", whole("--render", text.substr(colon + 1), 1, 256)};
  if (rendering.field && rendering.count != 1 && rendering.count != 2 && rendering.count != 4 &&
      rendering.count != ultrasound::most_patterns)
    fail("--render '" + text + "': expected 1, 2, 4 or " + std::to_string(ultrasound::most_patterns) +
         " patterns");
  return rendering;
}

/// What the clay and the hands are, beside the budget.
void readAxes(std::map<std::string, std::string>& given, Options& o) {
  for (const std::string& s : split(given["--spacing"], ','))
    o.spacings.push_back(numberOf("--spacing", s, 0.0, 0.1));
  for (const std::string& s : split(given["--skin"], ','))
    o.skins.push_back(numberOf("--skin", s, 0.0, 0.02));
  o.materials = split(given["--material"], ',');
  if (o.materials.empty()) o.materials = {""};
  o.models = split(given["--hand"], ',');
  for (const std::string& model : o.models)
    if (model != "kinematic" && model != "soft") fail("--hand '" + model + "': expected kinematic or soft");
  for (const std::string& text : split(given["--render"], ',')) o.renderings.push_back(renderingOf(text));
  if (o.spacings.empty() || o.skins.empty() || o.models.empty())
    fail("--spacing, --skin and --hand: expected at least one of each");
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
                                              {"--material", ""},
                                              {"--hand", "kinematic"},
                                              {"--skin", "0"},
                                              {"--render", ""},
                                              {"--reference", "minimise:32x64"},
                                              {"--threads", "2"},
                                              {"--csv", ""},
                                              {"--outcomes", ""},
                                              {"--shard", "1/1"},
                                              {"--merge", "no"},
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
  o.outcomes = given["--outcomes"];
  readShare(given, o);
  o.share = given["--share"].empty() ? shareFolder() : given["--share"];
  o.duration = numberOf("--duration", given["--duration"], 0.0, 3600.0);
  o.threads = whole("--threads", given["--threads"], 1, 1024);
  o.reference = settingOf("--reference", given["--reference"]);
  readAxes(given, o);
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
  if (o.settings.empty()) fail("no setting is given, expected at least one");
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

/// One run of the clay.
struct Play {
  clay::Budget budget;
  std::size_t skin;  // of the sweep's
  int aside;         // axis; -1: not
  int number;        // of all that are played
  std::string what;  // as in "minimise:4x8"
  double cost;       // in no unit
};

/// Hands whose skin has samples of one distance.
struct SkinSamples {
  double distance;  // m
  std::vector<HandSample> samples;
};

/// All that is played with clay and hands of one kind, in the order of the table.
struct Sweep {
  scene::Scene scene;
  std::unique_ptr<scene::Solids> solids;
  std::vector<SkinSamples> skins;  // the finest first
  PlayOptions how;
  Played played;
  std::string key;                        // of what is played, beside a Play
  std::vector<Play> settings, reference;  // reference: its step, half of it, and that aside along x, y, z
};

/// What is played by a sweep, without its settings.
Sweep sweepOf(double wanted_spacing, const std::string& material, const std::string& model,
              const Options& options) {
  Sweep sweep;
  sweep.scene = scene::loadScene(options.scene, options.share, wanted_spacing, {}, material);
  const scene::Scene& scene = sweep.scene;
  sweep.solids = std::make_unique<scene::Solids>(scene::loadRobotModel(scene.urdf), scene.motions);
  std::set<double> distances;
  for (const double skin : options.skins) distances.insert(skin > 0.0 ? skin : scene.config.spacing);
  for (const double distance : distances)
    sweep.skins.push_back({distance, handSamples(options.hands, options.duration, distance, options.share)});
  sweep.how.threads = options.threads;
  sweep.how.renderings = options.renderings;
  sweep.how.array = rigPose(options.share, "array_pose");
  sweep.played = {options.scene, options.hands, scene.config.spacing, scene.particles.size()};
  sweep.played.material = material;
  sweep.played.model = model;
  sweep.played.tells_skin = sweep.skins.size() > 1;
  sweep.played.tells_rendering = !options.renderings.empty();
  for (const HandSample& sample : sweep.skins[0].samples) sweep.played.duration += sample.duration;
  sweep.key = "scene " + options.scene + ", hands " + options.hands + ", " + model;
  for (const SkinSamples& skin : sweep.skins) sweep.key += ", " + fingerprint(scene, skin.samples);
  for (const Rendering& rendering : options.renderings) sweep.key += ", " + nameOf(rendering);
  return sweep;
}

/// Adds what is to be played. \param number of the plays before
void addPlays(const Options& options, int& number, Sweep& sweep) {
  const auto play = [&](const clay::Budget& budget, std::size_t skin, int axis = -1) -> Play {
    constexpr double beside = 5.0;  // what a substep costs beside its iterations, in iterations
    std::string what = nameOf(budget.method) + ':' + std::to_string(budget.substeps) + 'x' +
                       std::to_string(budget.iterations) +
                       (axis < 0 ? "" : std::string(" aside along ") + "xyz"[axis]);
    if (skin > 0) what += " skin " + std::to_string(std::lround(1e6 * sweep.skins[skin].distance)) + " um";
    return {budget,
            skin,
            axis,
            number++,
            what,
            budget.substeps * (budget.iterations + beside) * static_cast<double>(sweep.played.particles) *
                sweep.played.duration};
  };
  for (const clay::Budget& setting : options.settings)
    for (std::size_t skin = 0; skin < sweep.skins.size(); ++skin)
      sweep.settings.push_back(play(setting, skin));
  clay::Budget halved = options.reference;
  halved.substeps *= 2;
  sweep.reference = {play(options.reference, 0), play(halved, 0), play(halved, 0, 0), play(halved, 0, 1),
                     play(halved, 0, 2)};
}

/// Plays, or finds what was played, and says how far it is.
class Player {
 public:
  Player(const Options& options, const std::vector<Sweep>& sweeps) : options_(options) {
    for (const Sweep& sweep : sweeps)
      for (const auto* plays : {&sweep.settings, &sweep.reference})
        for (const Play& play : *plays)
          if (isMine(play)) ++count_, left_ += play.cost;
  }

  /// Shards take turns, so that each has its share of the dear ones.
  bool isMine(const Play& play) const { return play.number % options_.shards == options_.shard - 1; }

  Outcome operator()(const Sweep& sweep, const Play& play) {
    ++done_;
    const std::string key = sweep.key + ", " + play.what, file = fileOf(sweep, play);
    std::optional<Outcome> outcome;
    if (!options_.outcomes.empty()) outcome = loadOutcome(file, key);
    if (!outcome) {
      if (options_.merge) fail("outcome '" + file + "' is missing, or of something else: " + key);
      tell(sweep, play);
      const auto start = std::chrono::steady_clock::now();
      const SkinSamples& skin = sweep.skins[play.skin];
      PlayOptions how = sweep.how;
      if (sweep.played.model == "soft") how.soft_skin = skin.distance;
      outcome = tools::play(play.aside < 0 ? sweep.scene : aside(sweep.scene, play.aside), *sweep.solids,
                            skin.samples, play.budget, how);
      seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      played_ += play.cost;
      if (!options_.outcomes.empty()) saveOutcome(file, key, *outcome);
    }
    left_ -= play.cost;
    return *outcome;
  }

 private:
  std::string fileOf(const Sweep& sweep, const Play& play) const {
    std::ostringstream name;
    name << std::filesystem::path(options_.scene).stem().string() << '_'
         << std::filesystem::path(options_.hands).stem().string() << '_'
         << (sweep.played.model == "soft" ? "soft_" : "")
         << std::filesystem::path(sweep.played.material).stem().string()
         << (sweep.played.material.empty() ? "" : "_") << 1e3 * sweep.played.spacing << "mm_" << play.what
         << ".outcome";
    std::string text = name.str();
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == ':' || c == ' '; }, '_');
    return (std::filesystem::path(options_.outcomes) / text).string();
  }
  void tell(const Sweep& sweep, const Play& play) const {
    std::string left;
    if (played_ > 0.0) left = ", some " + std::to_string(std::lround(seconds_ / played_ * left_)) + " s left";
    std::fprintf(stderr, "speed_accuracy: %d of %d%s: %s %s at %g mm\n", done_, count_, left.c_str(),
                 options_.scene.c_str(), play.what.c_str(), 1e3 * sweep.played.spacing);
  }

  const Options& options_;
  int count_ = 0, done_ = 0;
  double left_ = 0.0, played_ = 0.0;  // costs
  double seconds_ = 0.0;              // that what was played took
};

/// Plays a sweep and prints its table, line by line.
void printTable(const Sweep& sweep, Player& player, std::ofstream& csv) {
  const Outcome coarse = player(sweep, sweep.reference[0]), reference = player(sweep, sweep.reference[1]);
  const auto tell = [&](const char* role, const Play& play, const Outcome& outcome) {
    Row row{role, play.budget, outcome, compare(outcome, reference, sweep.played.spacing)};
    row.skin = sweep.skins[play.skin].distance;
    const auto finish = [&] {
      printRow(sweep.played, row);
      if (csv.is_open()) writeCsvRow(csv, sweep.played, row);
    };
    // Of settings alone: what is rendered has an error of its own, against the pressure of the same clay.
    const std::size_t renderings = std::string(role) == "setting" ? outcome.rendered.size() : 0;
    for (std::size_t k = 0; k < renderings; ++k) {
      row.rendering = nameOf(sweep.how.renderings[k]);
      row.rendered = outcome.rendered[k].ms > 0.0 ? outcome.rendered[k] : RenderedPressure{NAN, NAN};
      finish();
    }
    if (renderings == 0) finish();
    return row.errors;
  };
  printHead(sweep.played);
  std::vector<Errors> errors;
  for (const Play& setting : sweep.settings)
    errors.push_back(tell("setting", setting, player(sweep, setting)));
  Doubt doubt;
  doubt.step = tell("twice the step", sweep.reference[0], coarse);
  for (int k = 2; k < 5; ++k)
    doubt.aside =
        greatest(doubt.aside, tell("1 µm aside", sweep.reference[k], player(sweep, sweep.reference[k])));
  tell("reference", sweep.reference[1], reference);
  std::printf("\n%s\n", convergence(doubt, errors).c_str());
  std::fflush(stdout);
}

void run(const Options& options) {
  std::ofstream csv = openCsv(options.csv);
  if (!options.outcomes.empty()) std::filesystem::create_directories(options.outcomes);
  std::vector<Sweep> sweeps;
  int number = 0;
  for (const double spacing : options.spacings)
    for (const std::string& material : options.materials)
      for (const std::string& model : options.models) {
        sweeps.push_back(sweepOf(spacing, material, model, options));
        addPlays(options, number, sweeps.back());
      }
  Player player(options, sweeps);
  for (const Sweep& sweep : sweeps) {
    if (options.shards == 1) {
      printTable(sweep, player, csv);
      continue;
    }
    for (const auto* plays : {&sweep.settings, &sweep.reference})
      for (const Play& play : *plays)
        if (player.isMine(play)) player(sweep, play);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return runTool("speed_accuracy", usage, argc, argv, [&] { run(optionsOf(argc, argv)); });
}
