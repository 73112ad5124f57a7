// Fits a material to a measured press: depth of a tool in a sample of clay, and force on the tool.
//
//   fit_material --help
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>

#include "files/output_file.h"
#include "scene/scene.h"
#include "tools/material_fit.h"
#include "tools/press_curve.h"
#include "tools/share_folder.h"
#include "tools/tool_arguments.h"

namespace {

using namespace tactile_clay;
using namespace tactile_clay::tools;

constexpr const char* usage = R"(usage: fit_material CURVE.csv [OPTION:=VALUE]...

Fits a material to a measurement: a tool was pressed from above into a block or a cylinder of clay on a table. Writes
a material file. CURVE.csv has a line `time,depth,force` (s, m, N) for each moment. The depth is how far the lowest
point of the tool is below the top of the sample, 0 where it touches. The force is upward, on the tool.

  out:=FILE         material file to write                   [the curve's name, with .yaml]
  overwrite:=true|false  whether to replace a file                                [false]
  tool:=WHAT        disc, sphere, or plate, which is wider than the sample         [disc]
  radius:=M         of the disc or sphere, m                                      [0.008]
  block:="X Y Z"    edges of the sample, m                             [0.06 0.06 0.04]
  cylinder:="R H"   radius and height of the sample, m, instead of a block
  fit:=NAMES        parameters to fit, of stiffness, yield_stress, viscosity,
                    relaxation_time, friction         [stiffness,yield_stress,viscosity]
  material:=NAME    of config/materials, or a file: has the other parameters
                                                                        [modelling_clay]
  spacing:=M        distance of the particles, m; 0: a sixth of the sample's height, or
                    half of the radius of the disc or sphere if that is less          [0]
  quality:=NAME     of config/quality.yaml                                     [balanced]
  evaluations:=N    maximum number of simulated presses, roughly                    [150]
  share:=FOLDER     folder with config/          [found from the program's place]
)";

std::vector<double> numbersOf(const std::string& name, const std::string& text, std::size_t count) {
  std::istringstream words(text);
  std::vector<double> numbers;
  for (std::string word; words >> word;) numbers.push_back(numberOf(name, word, 1e-4, 1.0));
  if (numbers.size() != count)
    throw std::runtime_error(name + " '" + text + "': expected " + std::to_string(count) + " numbers, m");
  return numbers;
}

PressSetup::Tool toolNamed(const std::string& name) {
  if (name == "disc") return PressSetup::Tool::disc;
  if (name == "sphere") return PressSetup::Tool::sphere;
  if (name == "plate") return PressSetup::Tool::plate;
  throw std::runtime_error("tool '" + name + "': expected disc, sphere or plate");
}

PressSetup setupOf(const Arguments& given) {
  PressSetup setup;
  setup.tool = toolNamed(given["tool"]);
  setup.radius = given.number("radius", 1e-4, 1.0);
  if (given["cylinder"].empty()) {
    const std::vector<double> edges = numbersOf("block", given["block"], 3);
    setup.sample.size = {edges[0], edges[1], edges[2]};
  } else {
    const std::vector<double> size = numbersOf("cylinder", given["cylinder"], 2);
    setup.sample.kind = scene::Shape::Kind::cylinder;
    setup.sample.size = {size[0], size[0], size[1]};
  }
  setup.spacing = given.number("spacing", 0.0, 0.1);
  if (setup.spacing == 0.0) {
    setup.spacing = setup.height() / 6.0;
    if (setup.tool != PressSetup::Tool::plate) setup.spacing = std::min(setup.spacing, 0.5 * setup.radius);
  }
  return setup;
}

std::vector<std::string> namesIn(const std::string& list) {
  std::vector<std::string> names;
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) names.push_back(name);
  return names;
}

void run(int argc, char** argv) {
  if (argc < 2 || std::string(argv[1]).find(":=") != std::string::npos)
    throw std::runtime_error("expected fit_material CURVE.csv [OPTION:=VALUE]..., see --help");
  const std::string file = argv[1];
  const Arguments given(argc - 1, argv + 1,
                        {{"out", ""},
                         {"overwrite", "false"},
                         {"tool", "disc"},
                         {"radius", "0.008"},
                         {"block", "0.06 0.06 0.04"},
                         {"cylinder", ""},
                         {"fit", "stiffness,yield_stress,viscosity"},
                         {"material", "modelling_clay"},
                         {"spacing", "0"},
                         {"quality", "balanced"},
                         {"evaluations", "150"},
                         {"share", ""}});
  const std::string share = shareFolder(given["share"]);
  const std::string out =
      given["out"].empty() ? std::filesystem::path(file).stem().string() + ".yaml" : given["out"];
  const auto existing = given.flag("overwrite") ? files::Existing::replace : files::Existing::keep;
  if (existing == files::Existing::keep && std::filesystem::exists(out))
    throw std::runtime_error(out + ": exists already, expected a new name, or overwrite:=true");
  PressSetup setup = setupOf(given);
  setup.budget = scene::loadQuality(given["quality"], share);
  const clay::Material start = scene::loadMaterial(given["material"], share);
  const PressCurve curve = readPressCurve(file);
  try {
    check(setup, curve);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(file + ": " + e.what());
  }
  const std::vector<Window> windows = windowsOf(curve);
  const MaterialFit fit =
      fitMaterial([&](const clay::Material& m) { return modelForces(setup, m, curve, windows); },
                  measuredForces(curve, windows), start, guessedYieldStress(setup, curve),
                  namesIn(given["fit"]), static_cast<int>(given.number("evaluations", 10, 10000)));
  char line[200];
  std::vector<std::string> comments{"Fitted to " + std::filesystem::path(file).filename().string() + " by:"};
  std::string arguments = "fit_material";
  for (int k = 1; k < argc; ++k) arguments += std::string(" '") + argv[k] + "'";
  for (char& c : arguments)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  comments.push_back("  " + arguments);
  std::snprintf(line, sizeof line,
                "%zu windows of 1/60 s, spacing %.4g m: error of the force %.1f %% (root mean square)",
                windows.size(), setup.fittedSpacing(), 100.0 * fit.error);
  comments.emplace_back(line);
  files::writeWhole(out, materialFile(fit, comments), existing);
  std::printf("fit_material: %s: error %.1f %%, %d evaluations\n", out.c_str(), 100.0 * fit.error,
              fit.evaluations);
  for (const FitParameter& p : fit.parameters) {
    if (p.determined())
      std::printf("  %s %.4g, within a factor of %.2f\n", p.name.c_str(), p.value, std::exp(p.error));
    else
      std::printf("  %s %.4g: not determined by the curve\n", p.name.c_str(), p.value);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return runTool("fit_material", usage, argc, argv, [&] { run(argc, argv); });
}
