#pragma once

#include <termios.h>

#include <optional>
#include <string>

namespace tactile_clay::tools {

/// What a person wants from the array.
enum class Wish { none, stop, reset, stop_and_leave, ended };  // ended: the input has ended

/// The keys of a terminal. Each key counts at once: `r` resets, Ctrl-C stops and leaves, any other key stops.
/// A pipe or a file gives lines: `r` or `reset` resets, any other line stops.
class Keys {
 public:
  /// @param descriptor such as 0; the settings of a terminal are restored at the end
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

/// A foot switch. It is an input device of Linux (/dev/input/event...), of which any key that goes down
/// stops, and whose keys reach no other program; or a serial line, a FIFO or a file, of which any byte stops.
/// It never resets. A switch that disappears stops, and is opened again when it is back.
class FootSwitch {
 public:
  /// @throws std::runtime_error with one line if it cannot be opened
  explicit FootSwitch(std::string path);
  ~FootSwitch();
  FootSwitch(const FootSwitch&) = delete;
  FootSwitch& operator=(const FootSwitch&) = delete;

  /// To be called once there is something to read.
  Wish read();

  /// Tries to open it again.
  /// @return whether it is there
  bool reopen() noexcept;

  int descriptor() const { return descriptor_; }  // -1: it has disappeared

 private:
  void open();

  std::string path_;
  int descriptor_ = -1;
  bool keys_ = false;  // whether it is an input device
};

}  // namespace tactile_clay::tools
