#include "device/autd3.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "device/options.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/phase_solver.h"
#include "ultrasound/slip.h"
#include "values/pose.h"
#include "values/text.h"

namespace tactile_clay::device {
namespace {

using ultrasound::Modulation;

constexpr char self[] = "autd3";
constexpr std::size_t max_boards = 16;

/// Poses of the boards: six numbers for each.
/// @throws std::runtime_error with one line
std::vector<Eigen::Isometry3d> boardsOf(const std::map<std::string, std::string>& options) {
  const auto given = options.find("boards");
  const std::string text = given == options.end() || given->second.empty() ? "0 0 0 0 0 0" : given->second;
  const auto numbers = values::numbersOf(text);
  if (!numbers || numbers->empty() || numbers->size() % 6 != 0 || numbers->size() / 6 > max_boards ||
      !std::all_of(numbers->begin(), numbers->end(), [](double x) { return std::abs(x) <= 10.0; }))
    throw std::runtime_error(
        "autd3: boards is '" + text +
        "', expected six numbers a board, x y z roll pitch yaw from -10 to 10, of 1 to 16 boards");
  std::vector<Eigen::Isometry3d> boards;
  for (std::size_t k = 0; k < numbers->size(); k += 6) boards.push_back(values::poseOf(&(*numbers)[k]));
  return boards;
}

}  // namespace

std::vector<std::uint8_t> autd3Modulation(const Emission& emission) {
  const bool swells =
      emission.modulation == Modulation::amplitude || emission.modulation == Modulation::field;
  const double frequency = swells ? std::round(emission.modulation_frequency) : 0.0;
  if (swells && emission.modulation_frequency > 0.0 && frequency < 1.0)
    throw std::invalid_argument("autd3: modulation of " + values::text(emission.modulation_frequency) +
                                " Hz, expected 0 or at least 1 Hz, in whole Hz");
  constexpr auto samples = static_cast<std::size_t>(Autd3Boards::sample_rate);
  std::vector<std::uint8_t> buffer;
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) / Autd3Boards::sample_rate;
    const double amplitude =
        frequency > 0.0 ? ultrasound::envelope(Modulation::amplitude, std::fmod(frequency * t, 1.0)) : 1.0;
    const double mixed =
        ultrasound::withSlip(amplitude, emission.slip, std::clamp(ultrasound::slipWave(t), 0.0, 1.0));
    buffer.push_back(static_cast<std::uint8_t>(std::lround(255.0 * mixed)));
  }
  return buffer;
}

Autd3::~Autd3() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

Autd3::Settings Autd3::settingsOf(const std::map<std::string, std::string>& options) {
  Settings settings;
  const auto address = options.find("address");
  if (address == options.end() || address->second.empty())
    throw std::runtime_error("autd3: no address, expected IP:PORT of an AUTD3 server");
  settings.address = address->second;
  settings.boards = boardsOf(options);
  settings.layout = Autd3Boards::layoutOf(settings.boards);
  double& temperature = settings.acoustics.temperature;
  temperature = number(options, self, "temperature", temperature, -20.0, 60.0);
  settings.hold = holdOf(options, self);
  return settings;
}

void Autd3::requireOptions(const std::map<std::string, std::string>& options) const {
  settingsOf(options);
}

void Autd3::open(const std::map<std::string, std::string>& options) {
  if (thread_.joinable()) throw std::runtime_error("autd3: opened a second time");
  settings_ = settingsOf(options);
  boards_ = std::make_unique<Autd3Boards>(settings_.address, settings_.boards);
  fault_.clear();
  thread_ = std::thread([this] { run(); });
}

Capabilities Autd3::capabilities() const {
  Capabilities capabilities;
  capabilities.input = Input::drives;
  capabilities.layout = settings_.layout;
  capabilities.modulations = {Modulation::amplitude, Modulation::lateral, Modulation::spatiotemporal,
                              Modulation::field,     Modulation::circle,  Modulation::field_circle};
  capabilities.slip = true;
  capabilities.remarks = {
      "autd3: the boards have no watchdog: they play on where this process is killed. Keep their power "
      "switch at hand"};
  return capabilities;
}

std::optional<ultrasound::Drive> Autd3::drive(const std::vector<ultrasound::FocalPoint>& points) const {
  ultrasound::PhaseSolverOptions options;
  options.phase_levels = Autd3Boards::phase_levels;
  options.amplitude_levels = Autd3Boards::amplitude_levels;
  return ultrasound::solvePhases(settings_.layout, settings_.acoustics, points, options).drive;
}

std::optional<ultrasound::FieldSolution> Autd3::field(const std::vector<ultrasound::FocalPoint>& targets,
                                                      const ultrasound::FieldSolverOptions& options,
                                                      const std::vector<ultrasound::Drive>& before) const {
  ultrasound::FieldSolverOptions own = options;
  own.phase_levels = Autd3Boards::phase_levels;
  own.amplitude_levels = Autd3Boards::amplitude_levels;
  return ultrasound::solveField(settings_.layout, settings_.acoustics, targets, own, before);
}

void Autd3::submit(const Sound& sound) {
  Playing next;
  if (!sound.parts.empty()) {
    next.modulation = autd3Modulation(sound.emission);
    next.frequency = sound.emission.modulation_frequency;
    if (sound.emission.modulation == Modulation::amplitude) {
      next.patterns = {sound.parts.front().drive};
    } else {
      for (const Sound::Part* part : instants(sound)) next.patterns.push_back(part->drive);
      // A field of one pattern does not change.
      if (sound.parts.size() == 1) next.patterns.resize(1);
    }
    if (next.patterns.size() > Autd3Boards::max_patterns)
      throw std::runtime_error("autd3: " + std::to_string(next.patterns.size()) +
                               " patterns in a period, expected at most " +
                               std::to_string(Autd3Boards::max_patterns));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!fault_.empty()) throw std::runtime_error(fault_);
  wanted_ = std::move(next);
  renewed_ = Clock::now();
  new_ = true;
  changed_.notify_all();
}

void Autd3::stop() noexcept {
  const std::lock_guard<std::mutex> lock(mutex_);
  wanted_ = {};
  new_ = true;
  changed_.notify_all();
}

std::string Autd3::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return fault_;
}

/// Called by the thread, with the mutex unlocked.
void Autd3::send(const Playing& wanted) {
  if (wanted.patterns.empty()) {
    boards_->silence();
    return;
  }
  if (wanted.modulation != modulation_) {
    boards_->silence();  // or the old pattern would sound with the new modulation
    boards_->modulate(wanted.modulation);
    modulation_ = wanted.modulation;
  }
  boards_->play(wanted.patterns, wanted.frequency);
}

void Autd3::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    const bool held = sounds_ && Clock::now() - renewed_ > settings_.hold;
    if (ending_ || held) {
      wanted_ = {};
      new_ = sounds_;
    }
    if (new_) {
      new_ = false;
      const Playing now = wanted_;
      lock.unlock();
      std::string fault;
      try {
        send(now);
      } catch (const std::exception& error) {
        fault = error.what();
      }
      lock.lock();
      sounds_ = !now.patterns.empty();
      fault_ = fault;
      if (!fault.empty() && !ending_) changed_.wait_for(lock, settings_.hold, [this] { return ending_; });
      if (!fault.empty()) {  // try to silence the boards until this succeeds
        new_ = !ending_;
        wanted_ = {};
      }
      continue;
    }
    if (ending_) return;
    changed_.wait_for(lock, settings_.hold / 4, [this] { return new_ || ending_; });
  }
}

}  // namespace tactile_clay::device
