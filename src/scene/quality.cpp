#include "scene/quality.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "scene/scene.h"
#include "scene/yaml_reader.h"

namespace tactile_clay::scene {
namespace {

// Time of a step beside its iterations (neighbours, contacts, bonds, setup), in iterations: seven to eight,
// as measured by the benchmarks frame/2114 and frame/4169.
constexpr int iterations_a_setup = 8;

Quality readQuality(YamlMap& presets, const std::string& name) {
  YamlMap preset = presets.map(name, "a map of keys and values");
  Quality quality;
  quality.name = name;
  quality.budget.substeps = preset.get<int>("substeps", "a whole number >= 1");
  quality.budget.iterations = preset.get<int>("iterations", "a whole number >= 1");
  const auto solver = preset.get<std::string>("solver", "minimise", "minimise or paper");
  for (const auto& [key, errors] : {std::pair("kneading", &quality.kneading), {"wheel", &quality.wheel}}) {
    YamlMap map = preset.map(key, "a map of force and displacement");
    errors->force = map.get<double>("force", "a share of the reference's, 0 or more");
    errors->displacement = map.get<double>("displacement", "spacings, 0 or more");
    map.finish();
    if (errors->force < 0.0 || errors->displacement < 0.0) map.fail("errors expected >= 0");
  }
  preset.finish();
  try {
    quality.budget.method = clay::methodNamed(solver);
  } catch (const std::invalid_argument& e) {
    preset.fail(e.what());
  }
  if (quality.budget.substeps < 1 || quality.budget.iterations < 1)
    preset.fail("substeps and iterations expected >= 1");
  return quality;
}

const Quality& find(const std::vector<Quality>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Quality& q) { return q.name == name; });
  if (found != all.end()) return *found;
  std::string list;
  for (const Quality& quality : all) list += (list.empty() ? "" : ", ") + quality.name;
  throw std::runtime_error("quality '" + name + "' not found, expected one of: " + list);
}

}  // namespace

std::vector<Quality> loadQualities(const std::string& share) {
  YamlMap map = loadYaml((std::filesystem::path(share) / "config" / "quality.yaml").string());
  std::vector<Quality> all;
  for (const std::string& name : map.keys()) all.push_back(readQuality(map, name));
  return all;
}

clay::Budget loadQuality(const std::string& name, const std::string& share) {
  return find(loadQualities(share), name).budget;
}

std::vector<Quality> steadyQualities(std::vector<Quality> all) {
  all.erase(std::remove_if(all.begin(), all.end(),
                           [](const Quality& q) { return q.budget.method != clay::Method::minimise; }),
            all.end());
  return all;
}

std::size_t mostAccurate(const std::vector<double>& ms, double target) {
  std::size_t best = 0;
  for (std::size_t k = 0; k < ms.size(); ++k)
    if (ms[k] <= target) best = k;
  return best;
}

const Quality* coarserThan(const clay::Budget& budget, const std::vector<Quality>& steady) {
  const auto cost = [](const clay::Budget& b) {
    return static_cast<long>(b.substeps) * (b.iterations + iterations_a_setup);
  };
  const Quality* coarser = nullptr;
  for (const Quality& quality : steady)
    if (cost(quality.budget) < cost(budget)) coarser = &quality;
  return coarser;
}

std::string expectation(const Quality& quality) {
  char text[200];
  std::snprintf(text, sizeof text,
                "errors to expect when kneading: force on hands %.3g %%, shape %.2g spacings; on a wheel: "
                "%.3g %%, %.2g spacings",
                100.0 * quality.kneading.force, quality.kneading.displacement, 100.0 * quality.wheel.force,
                quality.wheel.displacement);
  return text;
}

void requireQuality(const QualityWish& wish, const std::vector<Quality>& all) {
  const auto fail = [&](const std::string& expected) {
    const std::string what = wish.quality == automatic ? "quality 'auto'" : "target_ms above 0";
    throw std::runtime_error(what + " fits the quality to the computer: expected " + expected);
  };
  if (wish.quality != automatic) find(all, wish.quality);
  if (!wish.adapts()) return;
  if (wish.lockstep)
    fail("one of the presets and target_ms 0 in lockstep, where nothing depends on the clock");
  if (wish.substeps != 0 || wish.iterations != 0) fail("no substeps and iterations of your own");
  if (!wish.solver.empty() && clay::methodNamed(wish.solver) != clay::Method::minimise)
    fail("the solver minimise");
  if (wish.quality != automatic && find(all, wish.quality).budget.method != clay::Method::minimise)
    fail("a preset of the solver minimise");
}

}  // namespace tactile_clay::scene
