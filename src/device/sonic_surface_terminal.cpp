#include "device/sonic_surface_terminal.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

namespace tactile_clay::device {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::duration<double> byte_time(10.0 / 230400.0);
constexpr std::size_t remembered = 24;  // number of swaps
constexpr auto steady = 100ms;          // after this time without a swap, nothing is modulated by swaps
constexpr int look = 50;                // ms, between looks at `ending_`

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool same(const ultrasound::Drive& a, const ultrasound::Drive& b) {
  return a.phase == b.phase && a.amplitude == b.amplitude;
}

}  // namespace

SonicSurfaceTerminal::SonicSurfaceTerminal(std::string path, std::size_t boards, bool tactile)
    : path_(std::move(path)), boards_(boards, tactile) {
  const auto give_up = [this](const std::string& what) {
    const std::string why = std::strerror(errno);
    if (slave_ >= 0) ::close(slave_);
    if (master_ >= 0) ::close(master_);
    throw std::runtime_error("wire '" + path_ + "': " + what + ": " + why);
  };
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0) give_up("no pseudo-terminal");
  char name[128];
  if (::ptsname_r(master_, name, sizeof name) != 0) give_up("a pseudo-terminal without name");
  slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (slave_ < 0) give_up("the pseudo-terminal cannot be opened");
  termios settings{};
  ::tcgetattr(slave_, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(slave_, TCSANOW, &settings);
  struct stat there {};
  if (::lstat(path_.c_str(), &there) == 0 && S_ISLNK(there.st_mode)) ::unlink(path_.c_str());
  if (::symlink(name, path_.c_str()) != 0) give_up("cannot be made a link, expected a name that is free");
  thread_ = std::thread([this] { run(); });
}

SonicSurfaceTerminal::~SonicSurfaceTerminal() {
  ending_ = true;
  thread_.join();
  ::unlink(path_.c_str());
  ::close(slave_);
  ::close(master_);
}

void SonicSurfaceTerminal::run() {
  std::uint8_t bytes[4096];
  while (!ending_) {
    pollfd wait{master_, POLLIN, 0};
    if (::poll(&wait, 1, look) <= 0) continue;
    const ssize_t got = ::read(master_, bytes, sizeof bytes);
    if (got <= 0) continue;
    const std::lock_guard<std::mutex> lock(mutex_);
    wire_ = std::max(wire_, Clock::now());
    for (ssize_t i = 0; i < got; ++i) {
      wire_ += std::chrono::duration_cast<Clock::duration>(byte_time);
      const bool sounded = boards_.sounds();
      const bool swapped = boards_.feed(bytes[i]);
      if (sounded && (swapped || !boards_.sounds()))
        sounded_until_ = wire_;  // switching the clocks off ends a sound, too
      if (!swapped) continue;
      ++swaps_;
      last_.push_back({wire_, boards_.sounds(), boards_.drive()});
      if (last_.size() > remembered) last_.pop_front();
    }
  }
}

SonicSurfaceTerminal::State SonicSurfaceTerminal::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  State state;
  state.swaps = swaps_;
  state.faults = boards_.faults();
  state.sounded_until = sounded_until_;
  state.sounds = boards_.sounds();
  state.frequency = boards_.modulation();
  const double always = state.frequency > 0.0 ? 0.5 : 1.0;
  if (!boards_.may_sound() || last_.empty()) return state;
  if (Clock::now() - last_.back().when > steady) {
    if (boards_.sounds()) state.patterns.push_back({boards_.drive(), always});
    return state;
  }
  const auto newest =
      std::find_if(last_.rbegin(), last_.rend(), [](const Swap& swap) { return swap.sounds; });
  if (newest == last_.rend()) return state;
  // Intervals between swaps, s: those with the newest pattern, and the others with their pattern.
  std::vector<double> its, others;
  std::optional<ultrasound::Drive> other;
  for (std::size_t i = 0; i + 1 < last_.size(); ++i) {
    const double time = std::chrono::duration<double>(last_[i + 1].when - last_[i].when).count();
    const bool newest_plays = same(last_[i].drive, newest->drive);
    (newest_plays ? its : others).push_back(time);
    if (!newest_plays && last_[i].sounds) other = last_[i].drive;
  }
  if (its.empty() || others.empty()) {
    state.patterns.push_back({newest->drive, always});
    return state;
  }
  const double on = median(its), off = median(others);
  state.frequency = 1.0 / (on + off);
  state.patterns.push_back({newest->drive, on / (on + off)});
  // Two patterns that alternate permanently both sound. Otherwise the older one is ending.
  const bool both_sound = last_.back().sounds && last_[last_.size() - 2].sounds;
  if (other && both_sound) state.patterns.push_back({*other, off / (on + off)});
  return state;
}

}  // namespace tactile_clay::device
