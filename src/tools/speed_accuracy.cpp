// Speed and accuracy of budgets: plays a scene, with or without a hand, over a grid of solver, substeps,
// iterations and particle spacing, headless and in lockstep, and prints the error of each against a converged
// reference.
//
//   speed_accuracy --help
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/accuracy_options.h"
#include "tools/accuracy_report.h"
#include "tools/accuracy_sweep.h"
#include "tools/outcome.h"
#include "tools/tool_arguments.h"

namespace {

using namespace tactile_clay::tools;

constexpr const char* usage = R"(usage: speed_accuracy [--OPTION VALUE]...

Plays a scene with every setting of a grid, and compares it with a reference of many small steps. Prints a table in
Markdown, and writes CSV.

  --scene NAME         a scene of config/scenes, or a file                      [incline]
  --hands WHICH        none, knead, potter, press, a score of config/hands, its YAML
                       file, or a Leap recording                        [none]
                       (.ndjson or .ndjson.gz, placed by config/rig.yaml)
  --duration S         simulated time, s           [that of the hands; without hands 1.2]
  --solver LIST        minimise, paper                            [minimise,paper]
  --substeps LIST      per frame of 1/60 s                                 [1,2,4]
  --iterations LIST    per substep                                        [4,8,16]
  --also LIST          single settings in addition to the grid, such as paper:1x5  [none]
  --spacing LIST       distance of the particles, m; 0: the spacing of the scene    [0]
  --material LIST      of all bodies, such as putty,hard_wax              [the scene's]
  --hand LIST          kinematic, soft                                    [kinematic]
  --skin LIST          distance of the skin samples, m; 0: the spacing              [0]
  --render LIST        pressure on the skin as focal points or as a field, such as
                       points:4,points:8,field:1 (patterns)                    [none]
  --reference SETTING  the step of the reference is half of this         [minimise:32x64]
                       The reference is played three more times, with the clay moved
                       by a micrometre along x, y and z. No error can be smaller than
                       the difference that this makes.
  --threads N          of the clay                                                  [2]
  --csv FILE           one line for each setting and reference              [none]
  --outcomes FOLDER    keeps each result there, and plays nothing whose result is
                       there: a sweep that was stopped continues           [none]
  --shard I/N          plays a share of the sweep into --outcomes, and prints no
                       table: computer I of N                               [1/1]
  --merge yes|no       plays nothing: makes the table from --outcomes        [no]
  --share FOLDER       folder with config/             [found from the program's place]

Each spacing, material and hand has its own reference, with the finest skin of the list. Columns of the table (errors
are differences from that reference):
  ms a frame      wall time of the steps of 1/60 s, median and 99th percentile
  displacement    distance of the particles from those of the reference at the end, root mean square, spacings
  height          of the highest particle above the solids below it, at the end, mm; and its error
  force           of the clay on each hand, or on the solids without hands, means of 0.1 s: root mean square of the
                  error over that of the reference; nan if nothing is touched in the reference
  density         mean of max(rho / rho_0 - 1, 0) over particles and time
  pressure        that the array renders on the skin (--render, layout usx), ten times a second: root mean square error
                  over the pressure of the clay there, at the best common scale; and the time that rendering took, ms
  volume          inside the surface where the smoothed clay has half of its density, end over start - 1
)";

std::ofstream openCsv(const std::string& path) {
  std::ofstream csv;
  if (path.empty()) return csv;
  csv.open(path);
  if (!csv) throw std::runtime_error("--csv '" + path + "' cannot be written");
  writeCsvHead(csv);
  return csv;
}

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
    // Only for settings: a rendering has an error of its own, against the pressure of the same clay.
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
    doubt.aside = max(doubt.aside, tell("1 µm aside", sweep.reference[k], player(sweep, sweep.reference[k])));
  tell("reference", sweep.reference[1], reference);
  std::printf("\n%s\n", convergence(doubt, errors).c_str());
  std::fflush(stdout);
}

void run(const AccuracyOptions& options) {
  std::ofstream csv = openCsv(options.csv);
  if (!options.outcomes.empty()) std::filesystem::create_directories(options.outcomes);
  const std::vector<Sweep> sweeps = sweepsOf(options);
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
  return runTool("speed_accuracy", usage, argc, argv, [&] { run(accuracyOptions(argc, argv)); });
}
