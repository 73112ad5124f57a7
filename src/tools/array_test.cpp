// Tests an array without ROS nodes: plays patterns, and prints what a microphone should measure.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "device/array_device.h"
#include "device/loudness_meter.h"
#include "device/options.h"
#include "device/safety_gate.h"
#include "nodes/plugin.h"
#include "tools/tool_arguments.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/phase_solver.h"

namespace {

using namespace tactile_clay;
using Clock = std::chrono::steady_clock;

constexpr char usage[] =
    R"(Plays on an array without a graph, and prints what a microphone should read (Pa peak at 40 kHz, while the
sound is on).

  array_test device:=NAME [port:=FILE] [device_options:='key=value ...'] [test:=all] [microphone:='0 0 0.2']
             [channel:=all] [dwell:=0.5] [modulation_frequency:=200] [layout:=usx] [temperature:=20]
             [head_point:='-0.4 0 0.6'] [pressure_cap:=2000] [head_spl_cap:=110]

Tests:
  channels  one transducer after the other
  focus     a focus at the microphone, for ten times `dwell`
  sweep     a focus that passes the microphone along x, 40 mm to either side
  all       all of them

Positions are in m in the coordinate frame of the array: x and y along its sides, z out of its face. The safety gate
of the rig judges each sound. Ctrl-C silences the array and ends the program.
)";

constexpr auto renewal = std::chrono::microseconds(16667);  // as often as the rig
constexpr double sweep_half = 0.04;                         // m
constexpr int sweep_steps = 8;                              // to either side
constexpr double focus_dwells = 10.0;  // factor by which a focus stays longer, so that a finger can find it

volatile std::sig_atomic_t interrupted = 0;

Eigen::Vector3d place(const tools::Arguments& arguments, const std::string& key) {
  std::istringstream words(arguments[key]);
  std::vector<double> numbers;
  for (std::string word; words >> word;) numbers.push_back(tools::numberOf(key, word, -10.0, 10.0));
  if (numbers.size() != 3)
    throw std::runtime_error(key + " '" + arguments[key] + "': expected three numbers in m");
  return {numbers[0], numbers[1], numbers[2]};
}

std::map<std::string, std::string> deviceOptions(const tools::Arguments& arguments) {
  auto options = device::optionsOf("device_options", arguments["device_options"]);
  if (!arguments["port"].empty()) options["port"] = arguments["port"];
  options["temperature"] = arguments["temperature"];
  return options;
}

std::string text(const Eigen::Vector3d& at) {
  char line[80];
  std::snprintf(line, sizeof line, "(%.4f, %.4f, %.4f) m", at.x(), at.y(), at.z());
  return line;
}

/// An open array behind a safety gate, as in the rig. It is silent at the end.
class Bench {
 public:
  explicit Bench(const tools::Arguments& arguments)
      : name_(arguments["device"]),
        device_("tactile_clay::device::ArrayDevice", "device", name_),
        microphone_(place(arguments, "microphone")),
        frequency_(arguments.number("modulation_frequency", 0.0, 1000.0)),
        dwell_(arguments.number("dwell", 0.0, 3600.0)) {
    air_.temperature = arguments.number("temperature", -20.0, 60.0);
    config_.pressure_cap = arguments.number("pressure_cap", 1.0, 1e6);
    config_.head_spl_cap = arguments.number("head_spl_cap", 0.0, 200.0);
    device_->open(deviceOptions(arguments));
    const device::Capabilities capabilities = device_->capabilities();
    takes_drives_ = capabilities.input == device::Input::drives;
    layout_ =
        capabilities.layout.size() > 0 ? capabilities.layout : ultrasound::arrayLayouts(arguments["layout"]);
    meter_ = std::make_shared<device::LoudnessMeter>(layout_, air_, place(arguments, "head_point"), config_);
    for (const std::string& remark : capabilities.remarks) std::printf("%s\n", remark.c_str());
    std::printf("array '%s': %zu transducers, microphone at %s\n", name_.c_str(), layout_.size(),
                text(microphone_).c_str());
  }
  ~Bench() { device_->stop(); }

  void channels(const std::string& which) {
    if (!takes_drives_) {
      std::printf("channels: array '%s' takes focal points, so its channels cannot be played one by one\n",
                  name_.c_str());
      return;
    }
    std::size_t first = 0, last = layout_.size();
    if (which != "all") {
      first = static_cast<std::size_t>(
          tools::numberOf("channel", which, 0.0, static_cast<double>(layout_.size() - 1)));
      last = first + 1;
    }
    for (std::size_t n = first; n < last && interrupted == 0; ++n) {
      const ultrasound::Drive drive = play(microphone_, dwell_, [&](const auto&) {
        ultrasound::Drive one{std::vector<float>(layout_.size(), 0.0f),
                              std::vector<float>(layout_.size(), 0.0f)};
        one.amplitude[n] = 1.0f;
        return one;
      });
      tell("channel " + std::to_string(n) + " at " + text(layout_.position[n]), drive);
    }
  }

  void focus() {
    if (interrupted != 0) return;
    std::printf("focus at the microphone: a finger there should feel it\n");
    std::fflush(stdout);
    tell("focus at " + text(microphone_), play(microphone_, focus_dwells * dwell_));
  }

  void sweep() {
    for (int step = -sweep_steps; step <= sweep_steps && interrupted == 0; ++step) {
      const Eigen::Vector3d at = microphone_ + Eigen::Vector3d(sweep_half * step / sweep_steps, 0.0, 0.0);
      tell("focus at " + text(at), play(at, dwell_));
    }
  }

 private:
  using Solve = std::function<ultrasound::Drive(const std::vector<ultrasound::FocalPoint>&)>;

  ultrasound::Drive driveFor(const std::vector<ultrasound::FocalPoint>& points) const {
    if (const auto own = device_->drive(points)) return *own;
    return ultrasound::solvePhases(layout_, air_, points).drive;
  }

  ultrasound::Drive play(const Eigen::Vector3d& at, double seconds) {
    return play(at, seconds, [this](const auto& points) { return driveFor(points); });
  }

  /// @return the last drive that was played
  ultrasound::Drive play(const Eigen::Vector3d& at, double seconds, const Solve& solve) {
    device::SafetyGate gate(
        config_, {[&](const auto& points, const auto*) {
                    return ultrasound::PhaseSolution{solve(points), {}, {}};
                  },
                  [this](const auto& drive, const auto& points) { return (*meter_)(drive, points); }});
    gate.start();
    device::Emission emission;
    emission.modulation_frequency = frequency_;
    emission.points.resize(1);
    emission.points.front().position = at;
    emission.points.front().intensity = 1.0;
    ultrasound::Drive last;
    const auto start = Clock::now();
    auto next = start, before = start;
    do {
      const auto now = Clock::now();
      device::Occasion occasion;
      occasion.since_last = std::chrono::duration<double>(now - before).count();
      before = now;
      const device::Verdict verdict = gate.check(emission, occasion);
      if (!verdict.passes()) throw std::runtime_error("silent: " + verdict.reason);
      device_->submit(verdict.sound);
      lowered_ = verdict.lowered;
      last = verdict.sound.parts.front().drive;
      next += renewal;
      std::this_thread::sleep_until(next);
      if (!device_->fault().empty()) throw std::runtime_error(device_->fault());
    } while (Clock::now() - start < std::chrono::duration<double>(seconds) && interrupted == 0);
    return last;
  }

  void tell(const std::string& what, const ultrasound::Drive& drive) const {
    const double pressure = std::abs(ultrasound::pressureAt(layout_, air_, drive, microphone_));
    std::printf("%s: the microphone should read %.2f Pa peak (%.1f dB SPL), radiation pressure %.2f Pa%s\n",
                what.c_str(), pressure, ultrasound::soundPressureLevel(pressure),
                ultrasound::radiationPressure(air_, pressure),
                lowered_.empty() ? "" : ("; made weaker by " + lowered_).c_str());
    std::fflush(stdout);
  }

  std::string name_;
  nodes::Plugin<device::ArrayDevice> device_;
  Eigen::Vector3d microphone_;
  double frequency_, dwell_;  // Hz, s
  ultrasound::Acoustics air_;
  device::SafetyGateConfig config_;
  bool takes_drives_ = false;
  ultrasound::ArrayLayout layout_;
  std::shared_ptr<const device::LoudnessMeter> meter_;
  std::string lowered_;
};

void run(int argc, char** argv) {
  const tools::Arguments arguments(argc, argv,
                                   {{"device", "debug"},
                                    {"port", ""},
                                    {"device_options", ""},
                                    {"test", "all"},
                                    {"microphone", "0 0 0.2"},
                                    {"channel", "all"},
                                    {"dwell", "0.5"},
                                    {"modulation_frequency", "200"},
                                    {"layout", "usx"},
                                    {"temperature", "20"},
                                    {"head_point", "-0.4 0 0.6"},
                                    {"pressure_cap", "2000"},
                                    {"head_spl_cap", "110"}});
  const std::string test = arguments["test"];
  if (test != "all" && test != "channels" && test != "focus" && test != "sweep")
    throw std::runtime_error("test '" + test + "': expected all, channels, focus or sweep");
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  Bench bench(arguments);
  if (test == "all" || test == "channels") bench.channels(arguments["channel"]);
  if (test == "all" || test == "focus") bench.focus();
  if (test == "all" || test == "sweep") bench.sweep();
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runTool("array_test", usage, argc, argv, [&] { run(argc, argv); });
}
