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

/// SonicSurface boards behind a pseudo-terminal: a driver opens `path` as if it were their serial port. Bytes
/// count as come when a wire of 230400 baud would have brought them.
class SonicSurfaceTerminal {
 public:
  /// What plays, over a period of the modulation.
  struct State {
    struct Pattern {
      ultrasound::Drive drive;
      double share = 0.0;  // of the period, 0-1
    };
    std::vector<Pattern> patterns;  // that sound; none: silence
    double frequency = 0.0;         // Hz, of the modulation; 0: none
    std::size_t swaps = 0;          // since the start
    std::size_t faults = 0;         // bytes that no board should be sent
    /// When the last sound ended, or was swapped for another one; a sound of now may still go on.
    std::chrono::steady_clock::time_point sounded_until;
    bool sounds = false;  // now
  };

  /// Makes `path` a link to the terminal, and removes it in the end. A link that is there is replaced.
  /// @throws std::runtime_error with one line where the terminal or the link cannot be made
  SonicSurfaceTerminal(std::string path, std::size_t boards, bool tactile);
  ~SonicSurfaceTerminal();
  SonicSurfaceTerminal(const SonicSurfaceTerminal&) = delete;
  SonicSurfaceTerminal& operator=(const SonicSurfaceTerminal&) = delete;

  /// Modulation by swapping is told by the medians of the last intervals between swaps, with the newest
  /// pattern and without it, for uploads make some longer. The tactile firmware's is on for half of each
  /// period.
  State state() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Swap {
    Clock::time_point when;
    bool sounds = false;
    ultrasound::Drive drive;  // that plays since
  };

  void run();

  std::string path_;
  int master_ = -1, slave_ = -1;  // the slave is kept open, so that drivers may come and go
  mutable std::mutex mutex_;      // of what follows
  SonicSurfaceBoards boards_;
  std::deque<Swap> last_;  // the newest last
  Clock::time_point wire_;
  Clock::time_point sounded_until_;
  std::size_t swaps_ = 0;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace tactile_clay::device
