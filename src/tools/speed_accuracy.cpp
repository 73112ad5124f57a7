// What a budget buys: plays a scene, with or without a hand, over a grid of solver, substeps, iterations and
// particle spacing, headless and in lockstep, and tells the error of each against a converged reference.
//
//   speed_accuracy --help
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "clay/clay.h"
#include "clay/kernel.h"
#include "clay/lattice.h"
#include "hand/choreography.h"
#include "hand/hand_check.h"
#include "hand/kinematic_hand.h"
#include "hand/leap_recording.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "scene/yaml_reader.h"
#include "tools/quantile.h"

namespace {

using namespace tactile_clay;
using tools::quantile;

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

constexpr double frame = 1.0 / 60.0;  // s

struct Setting {
  clay::Budget budget;
  std::string name() const {
    const char* solver = budget.method == clay::Method::paper ? "paper" : "minimise";
    return std::string(solver) + ":" + std::to_string(budget.substeps) + "x" +
           std::to_string(budget.iterations);
  }
};

struct Options {
  std::string scene = "incline", hands = "none", csv, share;
  double duration = 0.0;  // s; 0: the hand's
  int threads = 2;
  std::vector<double> spacings{0.0};
  std::vector<Setting> settings;
  Setting reference;
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

double number(const std::string& option, const std::string& text, double low, double high) {
  std::istringstream stream(text);
  double value = 0.0;
  if (!(stream >> value) || !(stream >> std::ws).eof() || !(value >= low && value <= high)) {
    std::ostringstream line;
    line << option << " '" << text << "': expected a number from " << low << " to " << high;
    fail(line.str());
  }
  return value;
}

int whole(const std::string& option, const std::string& text, int low, int high) {
  const double value = number(option, text, low, high);
  if (value != std::floor(value)) fail(option + " '" + text + "': expected a whole number");
  return static_cast<int>(value);
}

Setting settingOf(const std::string& option, const std::string& text) {
  const std::size_t colon = text.find(':'), cross = text.find('x', colon == std::string::npos ? 0 : colon);
  if (colon == std::string::npos || cross == std::string::npos)
    fail(option + " '" + text + "': expected SOLVER:SUBSTEPSxITERATIONS, as in paper:1x5");
  Setting setting;
  setting.budget.method = clay::methodNamed(text.substr(0, colon));
  setting.budget.substeps = whole(option, text.substr(colon + 1, cross - colon - 1), 1, 10000);
  setting.budget.iterations = whole(option, text.substr(cross + 1), 1, 10000);
  return setting;
}

/// Folder with config/scenes, above the program or beside it.
std::string findShare() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (fs::path at = fs::read_symlink("/proc/self/exe", ignored); at.has_relative_path();
       at = at.parent_path()) {
    for (const fs::path& share : {at, at / "share" / "tactile_clay"}) {
      if (fs::is_directory(share / "config" / "scenes", ignored)) return share.string();
    }
  }
  fail("the package's folder with config/scenes is not above this program, expected --share FOLDER");
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
  o.share = given["--share"].empty() ? findShare() : given["--share"];
  o.duration = number("--duration", given["--duration"], 0.0, 3600.0);
  o.threads = whole("--threads", given["--threads"], 1, 1024);
  o.reference = settingOf("--reference", given["--reference"]);
  o.spacings.clear();
  for (const std::string& s : split(given["--spacing"], ','))
    o.spacings.push_back(number("--spacing", s, 0.0, 0.1));
  for (const std::string& solver : split(given["--solver"], ',')) {
    for (const std::string& substeps : split(given["--substeps"], ',')) {
      for (const std::string& iterations : split(given["--iterations"], ',')) {
        Setting setting;
        setting.budget.method = clay::methodNamed(solver);
        setting.budget.substeps = whole("--substeps", substeps, 1, 10000);
        setting.budget.iterations = whole("--iterations", iterations, 1, 10000);
        o.settings.push_back(setting);
      }
    }
  }
  for (const std::string& text : split(given["--also"], ',')) o.settings.push_back(settingOf("--also", text));
  if (o.settings.empty() || o.spacings.empty()) fail("no setting is given, expected at least one");
  return o;
}

// ---- The hand

/// The skin at the end of a piece of time.
struct Sample {
  double duration;  // s
  clay::Ghosts skin;
  std::vector<std::uint8_t> side;  // of each ghost: 0 left, 1 right
};

Sample sampleOf(double duration, const hand::Skin& skin) {
  return {duration, {skin.position, skin.normal, skin.velocity}, skin.side};
}

/// N, on the left and on the right hand; without hands, on all solids and zero.
using Load = Eigen::Matrix<double, 6, 1>;

std::vector<Sample> played(const hand::Score& score, double duration, double spacing) {
  hand::KinematicHands hands(spacing);
  std::vector<Sample> samples;
  const int count = static_cast<int>(std::lround((duration > 0.0 ? duration : score.duration()) / frame));
  for (int k = 1; k <= count; ++k) {
    const double t = k * frame;
    const auto stamp = std::chrono::nanoseconds(std::llround(t * 1e9));
    samples.push_back(sampleOf(frame, hands.update(score.sample(t).hands, stamp)));
  }
  return samples;
}

Eigen::Isometry3d trackerPose(const std::string& share) {
  scene::YamlMap rig = scene::loadYaml(share + "/config/rig.yaml");
  const auto p = rig.numbers("tracker_pose", 6, "x y z (m) roll pitch yaw (rad)");
  return Eigen::Translation3d(p[0], p[1], p[2]) * Eigen::AngleAxisd(p[5], Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(p[4], Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(p[3], Eigen::Vector3d::UnitX());
}

std::vector<Sample> recorded(const Options& options, double spacing) {
  const Eigen::Isometry3d tracker = trackerPose(options.share);
  hand::LeapRecording recording;
  hand::SourceOptions source;
  source.file = options.hands;
  recording.open(source);
  hand::KinematicHands hands(spacing);
  std::vector<Sample> samples;
  hand::TrackedFrame sample;
  std::optional<std::chrono::nanoseconds> before;
  double time = 0.0;
  while (recording.read(sample, {}) == hand::HandSource::Read::frame) {
    auto& seen = sample.hands;
    seen.erase(
        std::remove_if(seen.begin(), seen.end(), [](const auto& h) { return !hand::faultOf(h).empty(); }),
        seen.end());
    hand::keepOneHandASide(seen);
    for (hand::TrackedHand& h : seen) {
      for (hand::JointPose& joint : h.joints) {
        joint.position = tracker * joint.position;
        joint.orientation = Eigen::Quaterniond(tracker.rotation()) * joint.orientation;
      }
    }
    const auto passed = before ? sample.stamp - *before : std::chrono::nanoseconds(std::llround(frame * 1e9));
    before = sample.stamp;
    const double duration = std::clamp(std::chrono::duration<double>(passed).count(), 0.0, 1.0);
    time += duration;
    if (options.duration > 0.0 && time > options.duration) break;
    samples.push_back(sampleOf(duration, hands.update(seen, sample.stamp)));
  }
  return samples;
}

std::vector<Sample> samplesOf(const Options& options, double spacing) {
  if (options.hands == "none") {
    const double duration = options.duration > 0.0 ? options.duration : 1.2;
    return std::vector<Sample>(static_cast<std::size_t>(std::lround(duration / frame)), {frame, {}, {}});
  }
  if (options.hands == "knead") return played(hand::knead(), options.duration, spacing);
  if (options.hands == "potter") return played(hand::potter(), options.duration, spacing);
  if (options.hands == "press") return played(hand::pressFinger(), options.duration, spacing);
  if (!std::ifstream(options.hands))
    fail("--hands '" + options.hands +
         "': expected none, knead, potter, press, or a readable Leap recording");
  return recorded(options, spacing);
}

// ---- Measuring

/// What a setting made of the scene.
struct Outcome {
  std::vector<double> ms;               // of each frame's steps
  clay::VectorField position;           // m, at the end
  double height = 0.0;                  // m
  std::vector<Load> force;              // means of 0.1 s
  double mean_force = 0.0;              // N
  double density = 0.0, densest = 0.0;  // error
  double volume_change = 0.0;
};

/// m^3 where the smoothed clay, sum of W over that of the lattice, is above one half.
double volumeOf(const clay::VectorField& x, double spacing) {
  const clay::Kernel kernel(static_cast<float>(2.0 * spacing));
  const float full = clay::latticeSum(kernel, static_cast<float>(spacing));
  const float edge = static_cast<float>(0.5 * spacing);
  std::unordered_map<std::uint64_t, float> cells;
  const int reach = 4;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector3f at = x.at(i);
    const Eigen::Vector3i middle = (at / edge).array().floor().cast<int>();
    for (int a = -reach; a <= reach; ++a) {
      for (int b = -reach; b <= reach; ++b) {
        for (int c = -reach; c <= reach; ++c) {
          const Eigen::Vector3i cell = middle + Eigen::Vector3i(a, b, c);
          const Eigen::Vector3f centre = edge * (cell.cast<float>().array() + 0.5f).matrix();
          const float value = kernel.value((centre - at).norm());
          if (!(value > 0.0f)) continue;
          std::uint64_t key = 0;
          for (int k = 0; k < 3; ++k)
            key = key << 21U | static_cast<std::uint64_t>((cell[k] + (1 << 20)) & ((1 << 21) - 1));
          cells[key] += value;
        }
      }
    }
  }
  const auto inside =
      std::count_if(cells.begin(), cells.end(), [&](const auto& cell) { return cell.second >= 0.5f * full; });
  return static_cast<double>(inside) * edge * edge * edge;
}

/// m, of the highest particle over the solids that face up to it.
double heightOf(const clay::VectorField& x, const std::vector<clay::Solid>& solids,
                const Eigen::Vector3d& gravity, double spacing) {
  double highest = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    double nearest = INFINITY;
    for (const clay::Solid& solid : solids) {
      const clay::SurfacePoint point = surface(solid, solid.pose.inverse() * x.at(i).cast<double>());
      if ((solid.pose.linear() * point.normal).dot(gravity) < 0.0)
        nearest = std::min(nearest, point.distance);
    }
    if (std::isfinite(nearest)) highest = std::max(highest, nearest + 0.5 * spacing);
  }
  return highest;
}

Outcome play(const scene::Scene& scene, const scene::Solids& solids, const std::vector<Sample>& samples,
             const Setting& setting, int threads) {
  clay::ClayConfig config = scene.config;
  config.budget = setting.budget;
  config.threads = threads;
  config.sleeping = false;  // the solver alone is compared
  clay::Clay clay(config, scene.materials, scene.particles);
  const double first_volume = volumeOf(clay.particles().position, config.spacing);
  const double step = config.frame / setting.budget.substeps;
  Outcome outcome;
  double window = 0.0, time = 0.0;
  Load impulse = Load::Zero();
  const bool touched = std::any_of(samples.begin(), samples.end(),
                                   [](const Sample& sample) { return sample.skin.size() > 0; });
  for (const Sample& sample : samples) {
    const double before = clay.time();
    const auto solids_now = solids.at(before);
    const auto start = std::chrono::steady_clock::now();
    clay.advance(sample.skin, solids_now, sample.duration);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    const long steps = std::lround((clay.time() - before) / step);
    if (steps > 0)
      outcome.ms.push_back(ms / static_cast<double>(steps) * static_cast<double>(setting.budget.substeps));

    Load force = Load::Zero();
    if (touched)
      for (const clay::GhostForce& f : clay.ghostForces())
        force.segment<3>(3 * sample.side[f.ghost]) += f.force.cast<double>();
    else
      for (const Eigen::Vector3d& f : clay.solidForces()) force.head<3>() += f;
    outcome.mean_force += sample.duration * force.norm();
    outcome.density += sample.duration * clay.statistics().density_error_mean;
    outcome.densest = std::max(outcome.densest, clay.statistics().density_error_max);
    time += sample.duration, window += sample.duration;
    impulse += sample.duration * force;
    if (window > 0.1 - 1e-9) {
      outcome.force.push_back(impulse / window);
      window = 0.0;
      impulse.setZero();
    }
  }
  if (time > 0.0) outcome.mean_force /= time, outcome.density /= time;
  outcome.position = clay.particles().position;
  outcome.height = heightOf(outcome.position, solids.at(clay.time()), config.gravity, config.spacing);
  outcome.volume_change = volumeOf(outcome.position, config.spacing) / first_volume - 1.0;
  return outcome;
}

struct Errors {
  double displacement = 0.0;  // spacings
  double height = 0.0;        // of the reference's
  double force = 0.0;         // of the reference's
  double mean_force = 0.0;    // of the reference's
};

Errors compare(const Outcome& outcome, const Outcome& reference, double spacing) {
  Errors e;
  for (std::size_t i = 0; i < reference.position.size(); ++i)
    e.displacement += (outcome.position.at(i) - reference.position.at(i)).cast<double>().squaredNorm();
  e.displacement = std::sqrt(e.displacement / static_cast<double>(reference.position.size())) / spacing;
  e.height = outcome.height / reference.height - 1.0;
  double difference = 0.0, size = 0.0;
  for (std::size_t k = 0; k < reference.force.size(); ++k) {
    difference += (outcome.force[k] - reference.force[k]).squaredNorm();
    size += reference.force[k].squaredNorm();
  }
  e.force = size > 0.0 ? std::sqrt(difference / size) : NAN;
  e.mean_force = reference.mean_force > 0.0 ? outcome.mean_force / reference.mean_force - 1.0 : NAN;
  return e;
}

// ---- Telling

class Report {
 public:
  explicit Report(const Options& options) : options_(options) {
    if (options.csv.empty()) return;
    csv_.open(options.csv);
    if (!csv_) fail("--csv '" + options.csv + "' cannot be written");
    csv_ << "scene,hands,spacing_m,particles,role,solver,substeps,iterations,ms_frame_median,ms_frame_p99,"
            "ms_step_median,ms_step_p99,displacement_rms_spacings,height_m,height_error,force_error,"
            "mean_force_N,mean_force_error,density_error_mean,density_error_max,volume_change\n";
  }

  void title(double spacing, std::size_t particles, double duration) const {
    std::printf("**Scene `%s`, hands `%s`, %.1f s, %zu particles of %.3g mm**\n\n", options_.scene.c_str(),
                std::filesystem::path(options_.hands).filename().c_str(), duration, particles, 1e3 * spacing);
    std::printf(
        "| solver | substeps × iterations | ms a frame, median | p99 | displacement, spacings | "
        "height, mm | error | force, error | density, error | volume |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  }

  void row(const Setting& setting, double spacing, const char* role, const Outcome& o, const Errors& e) {
    const clay::Budget& b = setting.budget;
    const std::string solver = b.method == clay::Method::paper ? "paper" : "minimise";
    const bool reference = role != std::string("setting");
    std::printf("| %s%s | %d × %d | %.1f | %.1f | %.2f | %.1f | %+.1f %% | %.1f %% | %.2f %% | %+.1f %% |\n",
                reference ? (std::string(role) + ", ").c_str() : "", solver.c_str(), b.substeps, b.iterations,
                quantile(o.ms, 0.5), quantile(o.ms, 0.99), e.displacement, 1e3 * o.height, 1e2 * e.height,
                1e2 * e.force, 1e2 * o.density, 1e2 * o.volume_change);
    std::fflush(stdout);
    if (!csv_.is_open()) return;
    csv_ << options_.scene << ',' << options_.hands << ',' << spacing << ',' << o.position.size() << ','
         << role << ',' << solver << ',' << b.substeps << ',' << b.iterations << ',' << quantile(o.ms, 0.5)
         << ',' << quantile(o.ms, 0.99) << ',' << quantile(o.ms, 0.5) / b.substeps << ','
         << quantile(o.ms, 0.99) / b.substeps << ',' << e.displacement << ',' << o.height << ',' << e.height
         << ',' << e.force << ',' << o.mean_force << ',' << e.mean_force << ',' << o.density << ','
         << o.densest << ',' << o.volume_change << std::endl;
  }

  /// Whether the reference may be called converged: halving its step changed it by less than a tenth of the
  /// smallest error in the table.
  static void convergence(const Errors& halved, const std::vector<Errors>& rows) {
    const auto tell = [&](const char* what, double Errors::*error, double unit, const char* in) {
      double smallest = INFINITY;
      for (const Errors& e : rows) smallest = std::min(smallest, std::abs(e.*error));
      const double change = std::abs(halved.*error);
      if (!std::isfinite(change)) return;
      std::printf(
          "- %s: halving the reference's step changed it by %.3g%s; the smallest error above is %.3g%s: %s\n",
          what, unit * change, in, unit * smallest, in,
          change <= 0.1 * smallest ? "converged"
                                   : "not converged to a tenth of it; errors of the size of the change "
                                     "cannot be told from the reference's own");
    };
    std::printf("\n");
    tell("displacement", &Errors::displacement, 1.0, " spacings");
    tell("height", &Errors::height, 100.0, " %");
    tell("force", &Errors::force, 100.0, " %");
    std::printf("\n");
    std::fflush(stdout);
  }

 private:
  const Options& options_;
  std::ofstream csv_;
};

void run(const Options& options) {
  Report report(options);
  for (const double wanted : options.spacings) {
    const scene::Scene scene = scene::loadScene(options.scene, options.share, wanted);
    const scene::Solids solids(scene::readText(scene.urdf), scene.motions);
    const double spacing = scene.config.spacing;
    const std::vector<Sample> samples = samplesOf(options, spacing);
    double duration = 0.0;
    for (const Sample& sample : samples) duration += sample.duration;

    const auto playNoted = [&](const Setting& setting) {
      std::fprintf(stderr, "speed_accuracy: %s %s at %g mm\n", options.scene.c_str(), setting.name().c_str(),
                   1e3 * spacing);
      return play(scene, solids, samples, setting, options.threads);
    };
    Setting halved = options.reference;
    halved.budget.substeps *= 2;
    const Outcome coarse = playNoted(options.reference), reference = playNoted(halved);
    const Errors change = compare(coarse, reference, spacing);

    report.title(spacing, scene.particles.size(), duration);
    std::vector<Errors> errors;
    for (const Setting& setting : options.settings) {
      const Outcome outcome = playNoted(setting);
      errors.push_back(compare(outcome, reference, spacing));
      report.row(setting, spacing, "setting", outcome, errors.back());
    }
    report.row(options.reference, spacing, "twice the step", coarse, change);
    report.row(halved, spacing, "reference", reference, compare(reference, reference, spacing));
    Report::convergence(change, errors);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    for (int k = 1; k < argc; ++k) {
      if (argv[k] == std::string("--help") || argv[k] == std::string("-h")) {
        std::printf("%s", usage);
        return 0;
      }
    }
    run(optionsOf(argc, argv));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "speed_accuracy: %s\n", error.what());
    return 1;
  }
}
