#include "tools/accuracy_options.h"

#include <cstddef>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tools/share_folder.h"
#include "tools/tool_arguments.h"
#include "ultrasound/field_solver.h"

namespace tactile_clay::tools {
namespace {

using Given = std::map<std::string, std::string>;

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what);
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, at);) parts.push_back(part);
  return parts;
}

clay::Budget settingOf(const std::string& option, const std::string& text) {
  const std::size_t colon = text.find(':'), cross = text.find('x', colon == std::string::npos ? 0 : colon);
  if (colon == std::string::npos || cross == std::string::npos)
    fail(option + " '" + text + "': expected SOLVER:SUBSTEPSxITERATIONS, as in paper:1x5");
  clay::Budget setting;
  setting.method = clay::methodNamed(text.substr(0, colon));
  setting.substeps = wholeOf(option, text.substr(colon + 1, cross - colon - 1), 1, 10000);
  setting.iterations = wholeOf(option, text.substr(cross + 1), 1, 10000);
  return setting;
}

/// Reads which part of the sweep this process plays.
void readShare(Given& given, AccuracyOptions& o) {
  const std::string& shard = given["--shard"];
  const std::size_t slash = shard.find('/');
  if (slash == std::string::npos) fail("--shard '" + shard + "': expected I/N, as in 2/8");
  o.shards = wholeOf("--shard", shard.substr(slash + 1), 1, 10000);
  o.shard = wholeOf("--shard", shard.substr(0, slash), 1, o.shards);
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
  const Rendering rendering{kind == "field", wholeOf("--render", text.substr(colon + 1), 1, 256)};
  if (rendering.field && rendering.count != 1 && rendering.count != 2 && rendering.count != 4 &&
      rendering.count != ultrasound::max_patterns)
    fail("--render '" + text + "': expected 1, 2, 4 or " + std::to_string(ultrasound::max_patterns) +
         " patterns");
  return rendering;
}

/// Reads the properties of clay and hands, without the budget.
void readAxes(Given& given, AccuracyOptions& o) {
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

}  // namespace

AccuracyOptions accuracyOptions(int argc, char** argv) {
  Given given = {{"--scene", "incline"},
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
  AccuracyOptions o;
  o.scene = given["--scene"];
  o.hands = given["--hands"];
  o.csv = given["--csv"];
  o.outcomes = given["--outcomes"];
  readShare(given, o);
  o.share = shareFolder(given["--share"]);
  o.duration = numberOf("--duration", given["--duration"], 0.0, 3600.0);
  o.threads = wholeOf("--threads", given["--threads"], 1, 1024);
  o.reference = settingOf("--reference", given["--reference"]);
  readAxes(given, o);
  for (const std::string& solver : split(given["--solver"], ',')) {
    for (const std::string& substeps : split(given["--substeps"], ',')) {
      for (const std::string& iterations : split(given["--iterations"], ',')) {
        clay::Budget setting;
        setting.method = clay::methodNamed(solver);
        setting.substeps = wholeOf("--substeps", substeps, 1, 10000);
        setting.iterations = wholeOf("--iterations", iterations, 1, 10000);
        o.settings.push_back(setting);
      }
    }
  }
  for (const std::string& text : split(given["--also"], ',')) o.settings.push_back(settingOf("--also", text));
  if (o.settings.empty()) fail("no setting is given, expected at least one");
  return o;
}

}  // namespace tactile_clay::tools
