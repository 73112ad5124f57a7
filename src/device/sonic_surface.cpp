#include "device/sonic_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "device/options.h"
#include "device/sonic_surface_corrections.h"
#include "safety/silence_times.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/focus_peak.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::device {
namespace {

using namespace std::chrono_literals;
using sonic_surface::Firmware;

constexpr char self[] = "sonic_surface";
constexpr auto retry = 250ms;            // between tries to open a lost port
constexpr auto open_patience = 1000ms;   // for the guard of a driver that has just died
constexpr std::size_t most_points = 16;  // of a board, at a time: 16 transducers each
constexpr unsigned patterns = 64;        // of channels that are on, to choose from
constexpr double near_focus = 0.0019;    // m, in which a focus has its peak
constexpr int fewest = 4;                // channels that make a focus; three or two make fringes, one a wave

ultrasound::ArrayLayout layoutOf(std::size_t boards, const Eigen::Isometry3d& second) {
  std::string csv = "channel,column,row\n";
  const auto order = sonic_surface::channelOrder();
  for (std::size_t n = 0; n < order.size(); ++n)
    csv += std::to_string(n) + "," + std::to_string(order[n].first) + "," + std::to_string(order[n].second) +
           "\n";
  ultrasound::ArrayLayout layout = ultrasound::arrayLayout("sonic_surface", csv);
  for (std::size_t n = 0; boards == 2 && n < order.size(); ++n) {
    layout.position.push_back(second * layout.position[n]);
    layout.normal.push_back(second.linear() * layout.normal[n]);
  }
  return layout;
}

Eigen::Isometry3d pose(const std::vector<double>& n) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.translation() << n[0], n[1], n[2];
  result.linear() =
      (Eigen::AngleAxisd(n[5], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(n[4], Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(n[3], Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return result;
}

ultrasound::PhaseSolverOptions solverOptions(Firmware firmware) {
  ultrasound::PhaseSolverOptions options;
  options.phase_levels = firmware == Firmware::stock ? 32 : 16;
  return options;
}

/// Turns that are added to the phases of each channel on the way to the wire: what its transducer needs, less
/// what the firmware adds by itself.
std::vector<double> addedPhases(const std::map<std::string, std::string>& options, std::size_t boards) {
  std::vector<double> added;
  const auto add = [&](const char* key, std::size_t board, double factor) {
    const auto given = options.find(key);
    if (given == options.end() || given->second.empty() || given->second == "none") return;
    if (board >= boards)
      throw std::runtime_error(std::string(self) + ": " + key + " is '" + given->second +
                               "', expected it with boards=2 only");
    const std::vector<double> turns = sonic_surface::readCorrections(given->second);
    added.resize(boards * sonic_surface::channels, 0.0);
    for (std::size_t n = 0; n < turns.size(); ++n) added[board * turns.size() + n] += factor * turns[n];
  };
  add("corrections", 0, 1.0);
  add("second_corrections", 1, 1.0);
  for (std::size_t board = 0; board < boards; ++board) add("firmware_corrections", board, -1.0);
  return added;
}

/// The transducers that sound, and which of the layout each of them is.
std::pair<ultrasound::ArrayLayout, std::vector<std::size_t>> channelsThatAreOn(
    const ultrasound::ArrayLayout& layout, const ultrasound::Drive& drive) {
  std::pair<ultrasound::ArrayLayout, std::vector<std::size_t>> on;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    if (drive.amplitude[n] == 0.0f) continue;
    on.first.position.push_back(layout.position[n]);
    on.first.normal.push_back(layout.normal[n]);
    on.second.push_back(n);
  }
  return on;
}

}  // namespace

SonicSurface::~SonicSurface() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  guard_.reset();  // before the port, on which it writes its last silence
}

void SonicSurface::open(const std::map<std::string, std::string>& options) {
  if (thread_.joinable()) throw std::runtime_error("sonic_surface: opened a second time");
  const auto port = options.find("port");
  if (port == options.end() || port->second.empty())
    throw std::runtime_error("sonic_surface: no port, expected the device file of a serial port");
  path_ = port->second;
  boards_ = {};
  if (choice(options, self, "firmware", "stock", {"stock", "tactile"}) == "tactile")
    boards_.firmware = Firmware::tactile;
  boards_.count = choice(options, self, "boards", "1", {"1", "2"}) == "2" ? 2 : 1;
  if (boards_.count == 2 && boards_.firmware == Firmware::tactile)
    throw std::runtime_error("sonic_surface: boards is '2', expected 1 with the tactile firmware");
  boards_.first = choice(options, self, "board", "primary", {"primary", "secondary"}) == "primary" ? 0 : 1;
  if (boards_.first == 1 && (boards_.count == 2 || boards_.firmware == Firmware::tactile))
    throw std::runtime_error(
        "sonic_surface: board is 'secondary', expected one board with the stock firmware");
  added_ = addedPhases(options, boards_.count);
  const auto told = [&](const char* key) { return options.count(key) > 0 && !options.at(key).empty(); };
  remarks_.clear();
  if (boards_.firmware == Firmware::tactile && !told("corrections") && !told("firmware_corrections"))
    remarks_.push_back(
        "sonic_surface: the tactile firmware as published adds phase corrections of its authors' board to "
        "what it is sent, which leave a tenth of the pressure on another board; expected "
        "firmware_corrections, "
        "the file with what yours adds, or none, or corrections of a calibration");
  guarded_ = choice(options, self, "guard", "true", {"true", "false"}) == "true";
  hold_ = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
      number(options, self, "hold", silence_times::seconds(silence_times::device_hold), 0.02, 10.0)));
  acoustics_.temperature = number(options, self, "temperature", acoustics_.temperature, -20.0, 60.0);
  layout_ = layoutOf(boards_.count,
                     pose(numbers(options, self, "second_board", {0.168, 0, 0, 0, 0, 0}, -10.0, 10.0)));

  const auto start = Clock::now();
  const auto patience = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(number(options, self, "wait", 0.0, 0.0, 600.0)));
  while (!port_) {
    try {
      connect();
    } catch (const std::exception& error) {
      port_.reset();
      const bool busy = std::string(error.what()).find("in use") != std::string::npos;
      const auto until = start + (busy ? std::max<Clock::duration>(patience, open_patience) : patience);
      if (Clock::now() > until) throw std::runtime_error(std::string(self) + ": " + error.what());
      std::this_thread::sleep_for(20ms);
    }
  }
  fault_.clear();
  thread_ = std::thread([this] { run(); });
}

Capabilities SonicSurface::capabilities() const {
  // Bytes of a frame; boards of the stock firmware are selected by one byte each.
  const std::size_t bytes = boards_.count == 2 ? 517 : boards_.firmware == Firmware::stock ? 259 : 258;
  // Steps of lateral modulation and STM would need 160 and more.
  Capabilities capabilities;
  capabilities.input = Input::drives;
  capabilities.layout = layout_;
  capabilities.max_points = boards_.count * most_points;
  capabilities.max_rate = 1.0 / sonic_surface::secondsOnWire(bytes);
  capabilities.modulations = {ultrasound::Modulation::amplitude, ultrasound::Modulation::field};
  capabilities.remarks = remarks_;
  return capabilities;
}

ultrasound::Drive SonicSurface::solve(const std::vector<ultrasound::FocalPoint>& points) const {
  const auto whole = ultrasound::solvePhases(layout_, acoustics_, points, solverOptions(boards_.firmware));
  std::vector<ultrasound::FocalPoint> sounding;
  std::vector<double> target;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!(whole.target[k] > 0.0)) continue;
    sounding.push_back(points[k]);
    target.push_back(whole.target[k]);
  }
  ultrasound::Drive best;
  std::size_t most = 0;
  for (unsigned pattern = 0; pattern < patterns; ++pattern) {
    ultrasound::Drive drive = sonic_surface::emitted(whole.drive, boards_.firmware, pattern, added_);
    const auto on = std::count(drive.amplitude.begin(), drive.amplitude.end(), 1.0f);
    if (on < fewest) {
      std::fill(drive.amplitude.begin(), drive.amplitude.end(), 0.0f);
      return drive;
    }
    if (on == static_cast<std::ptrdiff_t>(layout_.size())) return drive;
    solveAnew(sounding, target, drive);
    const std::size_t peaks = ultrasound::peaksWithin(near_focus, layout_, acoustics_, drive, sounding);
    if (pattern > 0 && peaks <= most) continue;
    most = peaks;
    best = std::move(drive);
    if (most == sounding.size()) break;
  }
  return best;
}

/// Phases of the channels that are on, for without the others the foci would be neither as strong nor where
/// they were. \param target amplitude of each point, Pa
void SonicSurface::solveAnew(std::vector<ultrasound::FocalPoint> points, const std::vector<double>& target,
                             ultrasound::Drive& drive) const {
  const auto [on, channel] = channelsThatAreOn(layout_, drive);
  double strongest = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k].intensity = target[k] / ultrasound::focusPressure(on, acoustics_, points[k].position);
    strongest = std::max(strongest, points[k].intensity);
  }
  for (ultrasound::FocalPoint& point : points) point.intensity /= strongest;  // all that the channels give
  const ultrasound::Drive part =
      ultrasound::solvePhases(on, acoustics_, points, solverOptions(boards_.firmware)).drive;
  for (std::size_t n = 0; n < channel.size(); ++n) drive.phase[channel[n]] = part.phase[n];
}

std::optional<ultrasound::Drive> SonicSurface::drive(
    const std::vector<ultrasound::FocalPoint>& points) const {
  return sonic_surface::emitted(solve(points), boards_.firmware, 0, added_);
}

std::optional<ultrasound::FieldSolution> SonicSurface::field(
    const std::vector<ultrasound::FocalPoint>& targets, const ultrasound::FieldSolverOptions& options,
    const std::vector<ultrasound::Drive>& before) const {
  ultrasound::FieldSolverOptions own = options;
  own.patterns = 1;  // the wire is too slow for more
  own.phase_levels = solverOptions(boards_.firmware).phase_levels;
  own.amplitude_levels = 0;
  ultrasound::FieldSolution solution = ultrasound::solveField(layout_, acoustics_, targets, own, before);
  ultrasound::Drive& drive = solution.drives.front();
  ultrasound::Drive heard = sonic_surface::emitted(drive, boards_.firmware, 0, added_);
  const auto on = std::count(heard.amplitude.begin(), heard.amplitude.end(), 1.0f);
  if (on < fewest) {
    std::fill(heard.amplitude.begin(), heard.amplitude.end(), 0.0f);
  } else if (on < static_cast<std::ptrdiff_t>(layout_.size())) {
    solveAnew(targets, solution.wanted, own, heard);
    heard = sonic_surface::emitted(heard, boards_.firmware, 0, added_);
  }
  drive = std::move(heard);
  ultrasound::judgeField(layout_, acoustics_, targets, solution);
  return solution;
}

/// Phases of the channels that are on, for the same field as strong as they can give it. \param wanted
/// amplitude at each target, Pa
void SonicSurface::solveAnew(std::vector<ultrasound::FocalPoint> targets, const std::vector<double>& wanted,
                             ultrasound::FieldSolverOptions options, ultrasound::Drive& drive) const {
  const auto [on, channel] = channelsThatAreOn(layout_, drive);
  ultrasound::Drive before{{}, std::vector<float>(channel.size(), 1.0f)};
  for (const std::size_t n : channel) before.phase.push_back(drive.phase[n]);
  const ultrasound::ArrayReach reach(on, acoustics_);
  double strongest = 1.0;
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const double most = reach.amplitude(targets[k].position);
    targets[k].intensity = most > 0.0 ? wanted[k] / most : 0.0;
    strongest = std::max(strongest, targets[k].intensity);
  }
  for (ultrasound::FocalPoint& target : targets) target.intensity /= strongest;
  options.amplitude = 1.0;
  const ultrasound::Drive part =
      ultrasound::solveField(on, acoustics_, targets, options, {before}).drives.front();
  for (std::size_t n = 0; n < channel.size(); ++n) drive.phase[channel[n]] = part.phase[n];
}

void SonicSurface::submit(const Sound& sound) {
  const Emission& emission = sound.emission;
  if (emission.modulation != ultrasound::Modulation::amplitude &&
      emission.modulation != ultrasound::Modulation::field)
    throw std::runtime_error(std::string(self) + ": modulation " + ultrasound::nameOf(emission.modulation) +
                             ", expected am or field: the wire is too slow to move points");
  std::optional<Pattern> pattern;
  if (!sound.parts.empty()) {
    pattern.emplace();
    pattern->bytes = sonic_surface::frame(sound.parts.front().drive, boards_, added_);
    if (boards_.firmware == Firmware::tactile)
      pattern->bytes.insert(pattern->bytes.begin(), sonic_surface::modulation(emission.modulation_frequency));
    else if (emission.modulation_frequency > 0.0)
      pattern->half_period = std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double>(0.5 / emission.modulation_frequency));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!fault_.empty()) throw std::runtime_error(fault_);
  wanted_ = std::move(pattern);
  renewed_ = Clock::now();
  changed_.notify_all();
}

void SonicSurface::stop() noexcept {
  const std::lock_guard<std::mutex> lock(mutex_);
  wanted_.reset();
  changed_.notify_all();
}

std::string SonicSurface::fault() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return fault_;
}

void SonicSurface::connect() {
  port_ = std::make_unique<SerialPort>(path_, sonic_surface::baud);
  if (!guarded_ && !port_->pseudoTerminal())
    throw std::runtime_error("'" + path_ + "': guard is false, expected true on a port of boards");
  if (guarded_)
    guard_ = std::make_unique<SilenceGuard>(port_->descriptor(), sonic_surface::silence(boards_),
                                            silence_times::guard_patience);
  wire_free_ = Clock::now();
  silence();  // whatever the boards played before
}

void SonicSurface::run() {
  while (true) {
    try {
      play();
      return;
    } catch (const std::exception& error) {
      const std::lock_guard<std::mutex> lock(mutex_);
      fault_ = std::string(self) + ": " + error.what() + "; silent until it is back";
      wanted_.reset();
    }
    guard_.reset();
    port_.reset();
    while (!port_) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        if (changed_.wait_for(lock, retry, [this] { return ending_; })) return;
      }
      try {
        connect();
      } catch (const std::exception&) {  // still away, as fault() says
        guard_.reset();
        port_.reset();
      }
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    fault_.clear();
  }
}

void SonicSurface::write(const std::vector<std::uint8_t>& bytes) {
  port_->write(bytes, silence_times::port_patience);
  wire_free_ = std::max(wire_free_, Clock::now()) +
               std::chrono::duration_cast<Clock::duration>(
                   std::chrono::duration<double>(sonic_surface::secondsOnWire(bytes.size())));
}

void SonicSurface::silence() {
  write(sonic_surface::silence(boards_));
  sounding_ = false;
}

/// Sooner than by a frame of silence alone. \param silence_behind whether the buffer that does not play is
/// silent
void SonicSurface::hush(bool silence_behind) {
  if (port_->waiting() > 0) {
    port_->drop();  // of an upload: without its end it is never played
    wire_free_ = Clock::now();
  } else if (silence_behind) {
    write({sonic_surface::swap_byte});
  }
  silence();
}

/// A guard that is gone or frozen cannot silence the boards any more, so they are silenced while that can be
/// done. The one that is gone stays so: what ended it may end the next one unseen. The mutex is held.
void SonicSurface::superviseGuard() {
  switch (guard_->beat()) {
    case SilenceGuard::State::there:
      fault_.clear();
      break;
    case SilenceGuard::State::frozen:
      fault_ = std::string(self) + ": the guard process does not answer; silent until it does";
      break;
    case SilenceGuard::State::gone:
      fault_ = std::string(self) + ": the guard process is gone; silent until the driver is started again";
      break;
  }
}

void SonicSurface::play() {
  std::optional<Pattern> playing;  // none: the boards are silent
  bool heard = false;              // it plays, and not the silent buffer behind it
  Clock::time_point next_swap, next_upload, last_beat = Clock::now(), checked;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    const auto now = Clock::now();
    if (now - checked > silence_times::guard_beat / 2) {
      checked = now;
      port_->check();
      if (guard_) superviseGuard();
      // The guard may have silenced boards that this thread believes to play.
      if (now - last_beat > silence_times::guard_patience / 2) sounding_ = true, playing.reset();
      last_beat = now;
    }
    if (!fault_.empty()) wanted_.reset();
    if (ending_ || (wanted_ && now - renewed_ > hold_)) wanted_.reset();

    if (!wanted_) {
      if (sounding_) {
        lock.unlock();
        hush(playing && playing->half_period.count() > 0 && heard);
        lock.lock();
        playing.reset();
      } else if (ending_) {
        return;
      } else {
        changed_.wait_for(lock, silence_times::guard_beat, [this] { return wanted_ || ending_; });
      }
      continue;
    }

    const bool modulated = playing && playing->half_period.count() > 0;
    const bool other = !(playing == wanted_);
    if (other && now >= next_upload && now >= wire_free_ && !(modulated && heard) && port_->waiting() == 0) {
      const Pattern pattern = *wanted_;
      lock.unlock();
      // Modulation needs silence behind the pattern: that is so after silence and between modulated patterns.
      if (pattern.half_period.count() > 0 && !modulated && sounding_) silence();
      sounding_ = true;
      const auto start = std::max(Clock::now(), wire_free_);
      write(pattern.bytes);
      playing = pattern;
      heard = true;
      next_swap = wire_free_ + pattern.half_period;
      next_upload = wire_free_;
      while (pattern.half_period.count() > 0 && next_upload < wire_free_ + (wire_free_ - start))
        next_upload += 2 * pattern.half_period;
      lock.lock();
    } else if (modulated && now >= next_swap) {
      lock.unlock();
      port_->write({sonic_surface::swap_byte}, silence_times::port_patience);
      lock.lock();
      heard = !heard;
      next_swap = std::max(next_swap, now - playing->half_period) + playing->half_period;
    } else {
      // An emission that is newer than the next time to act only renews, or waits for it.
      auto until = now + silence_times::guard_beat / 2;
      if (modulated) until = std::min(until, next_swap);
      if (other) until = std::min(until, std::max({next_upload, wire_free_, now + 500us}));
      changed_.wait_until(lock, until,
                          [&] { return !wanted_ || ending_ || (!other && !(playing == wanted_)); });
    }
  }
}

}  // namespace tactile_clay::device
