#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// A program that can stop an array.
class Supervisor {
 public:
  virtual ~Supervisor() = default;

  /// Empty while it is there; else one line: what is missing, and what helps. For one thread.
  virtual std::string missing() = 0;
};

/// The words of the parameter `supervisors`: "roslaunch", "master", both, or "none".
/// @throws std::runtime_error if a word is none of these, or if there is no word
std::set<std::string> requiredSupervisors(const std::string& text);

/// The programs that have to be there while an array sounds: the roslaunch that started this process, because
/// without it nothing reacts to Ctrl-C, and the master, because without it no new program finds `array/stop`.
/// A process that was started by hand has only the master.
class Supervisors {
 public:
  /// Starts to watch.
  /// @param required as for requiredSupervisors. If one is not required, it is only logged when it disappears
  /// and when it returns
  /// @throws std::runtime_error as requiredSupervisors
  explicit Supervisors(const std::string& required);

  /// Empty while all required supervisors are there, else the line of the first one that is missing. To be
  /// called again and again, by one thread: it logs who disappears and who returns.
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
