#include "scene/score_file.h"

#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "files/ends_with.h"
#include "scene/yaml_reader.h"

namespace tactile_clay::scene {
namespace {

constexpr char metres[] = "a number of metres";
constexpr char count[] = "a whole number";
constexpr std::size_t max_moves = 1000;

Eigen::Vector2d centre(YamlMap& yaml) {
  if (!yaml.has("centre")) return Eigen::Vector2d::Zero();
  const auto numbers = yaml.numbers("centre", 2, "[x, y] in metres");
  return {numbers[0], numbers[1]};
}

hand::PressFinger press(YamlMap& yaml, double scale) {
  hand::PressFinger move;
  move.scale = scale;
  move.centre = centre(yaml);
  move.block_height = yaml.get("block_height", move.block_height, metres);
  move.approach = yaml.get("approach", move.approach, metres);
  move.depth = yaml.get("depth", move.depth, metres);
  move.speed = yaml.get("speed", move.speed, "a speed in m/s");
  move.hold = yaml.get("hold", move.hold, "a time in s");
  return move;
}

hand::Score knead(YamlMap& yaml, double scale) {
  hand::Knead move;
  move.scale = scale;
  move.block_height = yaml.get("block_height", move.block_height, metres);
  move.depth = yaml.get("depth", move.depth, metres);
  move.aside = yaml.get("aside", move.aside, metres);
  move.draw = yaml.get("draw", move.draw, metres);
  move.strokes = yaml.get("strokes", move.strokes, count);
  return hand::knead(move);
}

hand::Score pinch(YamlMap& yaml, double scale) {
  hand::Pinch move;
  move.scale = scale;
  move.centre = centre(yaml);
  move.block_height = yaml.get("block_height", move.block_height, metres);
  move.approach = yaml.get("approach", move.approach, metres);
  move.reach = yaml.get("reach", move.reach, metres);
  move.width = yaml.get("width", move.width, metres);
  move.depth = yaml.get("depth", move.depth, metres);
  move.times = yaml.get("times", move.times, count);
  return hand::pinch(move);
}

hand::Score roll(YamlMap& yaml, double scale) {
  hand::Roll move;
  move.scale = scale;
  move.centre = centre(yaml);
  move.block_height = yaml.get("block_height", move.block_height, metres);
  move.approach = yaml.get("approach", move.approach, metres);
  move.depth = yaml.get("depth", move.depth, metres);
  move.travel = yaml.get("travel", move.travel, metres);
  move.times = yaml.get("times", move.times, count);
  return hand::roll(move);
}

hand::Score potter(YamlMap& yaml, double scale) {
  hand::Potter move;
  move.scale = scale;
  move.radius = yaml.get("radius", move.radius, metres);
  move.height = yaml.get("height", move.height, metres);
  move.depth = yaml.get("depth", move.depth, metres);
  move.low = yaml.get("low", move.low, metres);
  move.rise = yaml.get("rise", move.rise, "a share of the height");
  move.top = yaml.get("top", move.top, metres);
  move.lean = yaml.get("lean", move.lean, "an angle in rad");
  return hand::potter(move);
}

const std::map<std::string, std::function<hand::Score(YamlMap&, double)>> moves = {
    {"knead", knead},
    {"press_finger", [](YamlMap& yaml, double scale) { return hand::pressFinger(press(yaml, scale)); }},
    {"press_thumb", [](YamlMap& yaml, double scale) { return hand::pressThumb(press(yaml, scale)); }},
    {"press_flat", [](YamlMap& yaml, double scale) { return hand::flatPress(press(yaml, scale)); }},
    {"pinch", pinch},
    {"roll", roll},
    {"potter", potter}};

hand::Score readMove(YamlMap& yaml, double scale) {
  const auto name = yaml.get<std::string>("move", "the name of a move");
  const auto found = moves.find(name);
  if (found == moves.end()) {
    std::string known;
    for (const auto& [other, make] : moves) known += (known.empty() ? "" : ", ") + other;
    yaml.fail("unknown move '" + name + "', expected one of " + known);
  }
  try {
    hand::Score score = found->second(yaml, scale);
    yaml.finish();
    return score;
  } catch (const std::invalid_argument& error) {
    yaml.fail(error.what());
  }
}

std::string shipped(const std::string& name, const std::string& package_folder) {
  return package_folder + "/config/hands/" + name + ".yaml";
}

}  // namespace

bool isScore(const std::string& name, const std::string& package_folder) {
  return files::endsWith(name, ".yaml") || std::filesystem::is_regular_file(shipped(name, package_folder));
}

hand::TrackerScript loadScore(const std::string& name, const std::string& package_folder) {
  const bool is_file = name.find('/') != std::string::npos || name.find(".yaml") != std::string::npos;
  const std::string file = is_file ? name : shipped(name, package_folder);
  YamlMap yaml = loadYaml(file);
  hand::TrackerScript script;
  script.rate = yaml.get("rate", script.rate, "a frequency in Hz");
  script.sight = yaml.get("sight", script.sight, metres);
  script.seed = yaml.get("seed", script.seed, "a whole number of 0 or more");
  script.dropout_interval = yaml.get("dropout_interval", script.dropout_interval, "a time in s");
  script.dropout_duration = yaml.get("dropout_duration", script.dropout_duration, "a time in s");
  script.id_change_interval = yaml.get("id_change_interval", script.id_change_interval, "a time in s");
  hand::TrackerNoise noise;
  noise.position = yaml.get("noise_position", 0.0, metres);
  noise.angle = yaml.get("noise_angle", 0.0, "an angle in rad");
  const double scale = yaml.get("scale", 1.05, "the size of the person, 1 for the mean");
  const double pause = yaml.get("pause", 1.0, "a time in s");
  if (!(scale >= 0.5 && scale <= 2.0)) yaml.fail("'scale' is out of its range, expected 0.5 to 2");
  if (!(pause >= 0.1 && pause <= 60.0)) yaml.fail("'pause' is out of its range, expected 0.1 to 60 s");
  std::vector<hand::Score> scores;
  double duration = 0.0;  // s
  for (YamlMap& move : yaml.maps("moves")) {
    if (scores.size() == max_moves)
      move.fail("more than " + std::to_string(max_moves) + " moves, expected at most as many");
    scores.push_back(readMove(move, scale));
    duration += scores.back().duration() + pause;
    // Checked here and not at the end, so that too many moves never come into memory.
    if (!(duration <= hand::longest_score))
      move.fail("lasts until " + std::to_string(duration) + " s, expected a score of at most " +
                std::to_string(static_cast<int>(hand::longest_score)) + " s");
  }
  yaml.finish();
  if (scores.empty()) yaml.fail("no moves, expected a list of them under 'moves'");
  script.score = hand::inTurn(scores, pause);
  script.score.noise = noise;
  try {
    hand::ScriptedTracker check(script);
  } catch (const std::invalid_argument& error) {
    yaml.fail(error.what());
  }
  return script;
}

}  // namespace tactile_clay::scene
