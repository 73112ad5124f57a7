#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "device/sonic_surface_boards.h"

namespace tactile_clay::device {

/// SonicSurface boards behind a pseudo-terminal: a driver opens `path` as if it were their serial port. A
/// byte counts as received at the time when a wire of 230400 baud would have brought it.
class SonicSurfaceTerminal {
 public:
  /// The sound that plays, over one period of the modulation.
  struct State {
    struct Pattern {
      ultrasound::Drive drive;
      double share = 0.0;  // of the period, 0-1
    };
    std::vector<Pattern> patterns;  // patterns that sound; none: silence
    double frequency = 0.0;         // Hz, of the modulation; 0: none
    std::size_t swaps = 0;          // since the start
    std::size_t faults = 0;         // bytes that no board should receive
    /// Time when the last sound ended or was swapped for another one. A sound that plays now ends later.
    std::chrono::steady_clock::time_point sounded_until;
    bool sounds = false;  // whether the boards sound now
  };

  /// Makes `path` a link to the terminal. The destructor removes it. A link that exists is replaced.
  /// @throws std::runtime_error with one line if the terminal or the link cannot be made
  SonicSurfaceTerminal(std::string path, std::size_t boards, bool tactile);
  ~SonicSurfaceTerminal();
  SonicSurfaceTerminal(const SonicSurfaceTerminal&) = delete;
  SonicSurfaceTerminal& operator=(const SonicSurfaceTerminal&) = delete;

  /// Finds modulation by swapping from the last intervals between swaps: from their medians with the newest
  /// pattern and without it, because uploads make some intervals longer. The modulation of the tactile
  /// firmware is on for half of each period.
  State state() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Swap {
    Clock::time_point when;
    bool sounds = false;
    ultrasound::Drive drive;  // drive that plays since then
  };

  void run();

  std::string path_;
  int master_ = -1, slave_ = -1;  // slave_ is kept open, so that drivers may come and go
  mutable std::mutex mutex_;      // protects the members below, up to swaps_
  SonicSurfaceBoards boards_;
  std::deque<Swap> last_;  // the last swaps, the newest at the end
  Clock::time_point wire_;
  Clock::time_point sounded_until_;
  std::size_t swaps_ = 0;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace tactile_clay::device
