#pragma once

#include <termios.h>

#include <optional>
#include <string>

namespace tactile_clay::tools {

/// What somebody wants of the array.
enum class Wish { none, stop, reset, stop_and_leave, ended };  // ended: nothing more will come

/// The keys of a terminal, each of which counts at once: `r` resets, Ctrl-C stops and leaves, any other one
/// stops. From a pipe or a file come lines: `r` or `reset` resets, any other one stops.
class Keys {
 public:
  /// @param descriptor such as 0; a terminal is given back as it was in the end
  explicit Keys(int descriptor);
  ~Keys();
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  /// To be called once there is something to read.
  Wish read();

  int descriptor() const { return descriptor_; }
  bool terminal() const { return before_.has_value(); }

 private:
  int descriptor_;
  std::optional<termios> before_;  // settings; none: no terminal
  std::string line_;               // so far
};

/// A foot switch: an input device of Linux (/dev/input/event...), of which any key that goes down stops, and
/// which is kept from typing elsewhere; a serial line, a FIFO or a file, of which any byte stops. It never
/// resets. A switch that is gone stops, and is opened again once it is back.
class FootSwitch {
 public:
  /// @throws std::runtime_error with one line where it cannot be opened
  explicit FootSwitch(std::string path);
  ~FootSwitch();
  FootSwitch(const FootSwitch&) = delete;
  FootSwitch& operator=(const FootSwitch&) = delete;

  /// To be called once there is something to read.
  Wish read();

  /// Tries to open it again.
  /// @return whether it is there
  bool reopen() noexcept;

  int descriptor() const { return descriptor_; }  // -1: it is gone

 private:
  void open();

  std::string path_;
  int descriptor_ = -1;
  bool keys_ = false;  // an input device
};

}  // namespace tactile_clay::tools
