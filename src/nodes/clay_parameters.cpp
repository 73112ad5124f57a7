#include "nodes/clay_parameters.h"

#include <cctype>
#include <limits>
#include <stdexcept>

#include "nodes/share.h"
#include "scene/quality.h"
#include "scene/scene.h"

namespace tactile_clay::nodes {
namespace {

constexpr double any = std::numeric_limits<double>::infinity();  // the core checks ranges

/// The name of a material as the name of a group of parameters. Files may use any characters in it.
std::string groupOf(const std::vector<clay::Material>& materials, std::size_t k) {
  const auto plain = [](std::string name) {
    for (char& letter : name)
      if (!std::isalnum(static_cast<unsigned char>(letter))) letter = '_';
    return name;
  };
  const std::string name = plain(materials[k].name);
  bool taken = false;
  for (std::size_t other = 0; other < k; ++other) taken = taken || plain(materials[other].name) == name;
  return taken ? name + "_" + std::to_string(k) : name;
}

}  // namespace

ClayChoice readClay(Settings& settings, const clay::ClayConfig& config,
                    const std::vector<clay::Material>& materials) {
  ClayChoice choice{config, "", materials};
  clay::Budget& budget = choice.config.budget;
  choice.quality =
      settings.text("quality", "balanced", "how well a frame is solved: a preset of config/quality.yaml");
  if (choice.quality == scene::automatic)
    throw std::runtime_error(settings.nameOf("quality") +
                             ": 'auto' measures the computer at the start of the rig, expected a preset");
  const clay::Budget preset = budget = scene::loadQuality(choice.quality, packageFolder());
  // 0 or an empty text means the value of the preset, so that launch arguments can pass it on.
  if (const auto solver = settings.text("solver", "", "minimise or paper; empty: the preset's");
      !solver.empty())
    budget.method = clay::methodNamed(solver);
  if (const int n = settings.whole("substeps", 0, 0, 1000, "substeps per frame; 0: the preset's"))
    budget.substeps = n;
  if (const int n = settings.whole("iterations", 0, 0, 1000,
                                   "maximum number of iterations per substep; 0: the preset's"))
    budget.iterations = n;
  if (budget.substeps != preset.substeps || budget.iterations != preset.iterations)
    choice.quality = std::to_string(budget.substeps) + " x " + std::to_string(budget.iterations);
  choice.config.tolerance =
      settings.number("tolerance", config.tolerance, 0.0, any, "residual at which iterations stop, m/s^2");
  choice.config.sleeping =
      settings.truth("sleeping", true, "clay at rest is not simulated until something comes near");
  clay::validate(choice.config);
  for (std::size_t k = 0; k < materials.size(); ++k) {
    settings.group(groupOf(materials, k));
    for (const clay::Coefficient& c : clay::coefficients)
      choice.materials[k].*c.value = settings.number(groupOf(materials, k) + "/" + c.name,
                                                     materials[k].*c.value, c.low, c.high, c.meaning);
    clay::validate(choice.materials[k]);
  }
  return choice;
}

}  // namespace tactile_clay::nodes
