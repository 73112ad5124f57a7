#include "tools/accuracy_sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "scene/robot_model.h"
#include "tools/outcome_file.h"
#include "tools/rig_pose.h"

namespace tactile_clay::tools {
namespace {

/// The scene with its clay moved by a micrometre along an axis.
scene::Scene aside(scene::Scene scene, int axis) {
  for (clay::InitialParticle& particle : scene.particles) particle.position[axis] += 1e-6f;
  return scene;
}

/// A sweep without its plays.
Sweep sweepOf(double wanted_spacing, const std::string& material, const std::string& model,
              const AccuracyOptions& options) {
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
  for (const SweepSkin& skin : sweep.skins) sweep.key += ", " + fingerprint(scene, skin.samples);
  for (const Rendering& rendering : options.renderings) sweep.key += ", " + nameOf(rendering);
  return sweep;
}

/// Adds the plays of a sweep.
/// @param number of plays so far
void addPlays(const AccuracyOptions& options, int& number, Sweep& sweep) {
  const auto play = [&](const clay::Budget& budget, std::size_t skin, int axis = -1) -> Play {
    constexpr double beside = 5.0;  // cost of a time step without its iterations, in iterations
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

}  // namespace

std::vector<Sweep> sweepsOf(const AccuracyOptions& options) {
  std::vector<Sweep> sweeps;
  int number = 0;
  for (const double spacing : options.spacings)
    for (const std::string& material : options.materials)
      for (const std::string& model : options.models) {
        sweeps.push_back(sweepOf(spacing, material, model, options));
        addPlays(options, number, sweeps.back());
      }
  return sweeps;
}

Player::Player(AccuracyOptions options, const std::vector<Sweep>& sweeps) : options_(std::move(options)) {
  for (const Sweep& sweep : sweeps)
    for (const auto* plays : {&sweep.settings, &sweep.reference})
      for (const Play& play : *plays)
        if (isMine(play)) {
          ++count_;
          left_ += play.cost;
        }
}

Outcome Player::operator()(const Sweep& sweep, const Play& play) {
  ++done_;
  const std::string key = sweep.key + ", " + play.what, file = fileOf(sweep, play);
  std::optional<Outcome> outcome;
  if (!options_.outcomes.empty()) outcome = loadOutcome(file, key);
  if (!outcome) {
    if (options_.merge)
      throw std::runtime_error("outcome '" + file + "' is missing, or is not the outcome of " + key);
    tell(sweep, play);
    const auto start = std::chrono::steady_clock::now();
    const SweepSkin& skin = sweep.skins[play.skin];
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

std::string Player::fileOf(const Sweep& sweep, const Play& play) const {
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

void Player::tell(const Sweep& sweep, const Play& play) const {
  std::string left;
  if (played_ > 0.0) left = ", about " + std::to_string(std::lround(seconds_ / played_ * left_)) + " s left";
  const std::string what = options_.scene + " " + play.what;
  std::fprintf(stderr, "speed_accuracy: %d of %d%s: %s at %g mm\n", done_, count_, left.c_str(), what.c_str(),
               1e3 * sweep.played.spacing);
}

}  // namespace tactile_clay::tools
