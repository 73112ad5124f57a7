#pragma once

#include <memory>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// Somebody who can stop an array.
class Supervisor {
 public:
  virtual ~Supervisor() = default;

  /// Empty while it is there; else one line: who is missing, and what helps. Of one thread.
  virtual std::string missing() = 0;
};

/// Who has to be there while an array sounds: the roslaunch that started this process, for without it nobody
/// acts on Ctrl-C, and the master, for without it nobody new finds `array/stop`. A process that was started
/// by hand has only the master.
class Supervisors {
 public:
  /// Starts to watch.
  /// @param required "roslaunch", "master", both, or "none". One that is not required is told when it goes
  /// and comes back, and no more
  /// @throws std::runtime_error where a word is none of these
  explicit Supervisors(const std::string& required);

  /// Empty while all that are required are there, else the line of the first that is missing. To be called
  /// again and again, by one thread: it logs who goes and who comes back.
  std::string missing();

 private:
  struct Watched {
    std::string name;
    bool required;
    std::unique_ptr<Supervisor> supervisor;
    std::string told;  // its last line
  };
  void watch(const std::string& name, bool required, std::unique_ptr<Supervisor> supervisor);

  std::vector<Watched> watched_;
};

}  // namespace tactile_clay::nodes
