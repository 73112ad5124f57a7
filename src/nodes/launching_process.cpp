#include "nodes/launching_process.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include "safety/silence_times.h"

namespace tactile_clay::nodes {
namespace {

struct Stat {
  char state = 'X';
  pid_t parent = 0;
  std::uint64_t start = 0;
};

std::string pathOf(pid_t process, const char* file) {
  return "/proc/" + std::to_string(process) + "/" + file;
}

/// The state of a process as in proc(5); nothing if there is no such process.
std::optional<Stat> statOf(pid_t process) {
  std::ifstream file(pathOf(process, "stat"));
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  // The second field is a name in parentheses, which may contain any characters.
  std::istringstream fields(line.substr(std::min(line.rfind(')') + 1, line.size())));
  Stat stat;
  std::string skipped;
  fields >> stat.state >> stat.parent;
  for (int field = 5; field < 22; ++field) fields >> skipped;
  if (!(fields >> stat.start)) return std::nullopt;
  return stat;
}

std::vector<std::string> argumentsOf(pid_t process) {
  std::ifstream file(pathOf(process, "cmdline"));
  std::vector<std::string> arguments;
  for (std::string argument; std::getline(file, argument, '\0');) arguments.push_back(argument);
  return arguments;
}

/// Whether roslaunch started the process: it gives each node the name of its log.
bool wasLaunched(const std::vector<std::string>& arguments) {
  return std::any_of(arguments.begin(), arguments.end(),
                     [](const std::string& argument) { return argument.rfind("__log:=", 0) == 0; });
}

/// Whether the process is a keeper. A keeper ends when its parent ends it, so it is no supervisor.
bool isKeeper(const std::vector<std::string>& arguments) {
  return !arguments.empty() && arguments[0].substr(arguments[0].rfind('/') + 1) == "keep_running";
}

pid_t parentOf(pid_t process) {
  const auto stat = statOf(process);
  return stat ? stat->parent : 0;
}

bool isRoslaunch(const std::vector<std::string>& arguments) {
  return std::any_of(arguments.begin(), arguments.end(), [](const std::string& argument) {
    const std::string name = argument.substr(argument.rfind('/') + 1);
    return name == "roslaunch" || name == "rostest";
  });
}

}  // namespace

std::unique_ptr<LaunchingProcess> LaunchingProcess::find() {
  if (!wasLaunched(argumentsOf(::getpid()))) return nullptr;
  // A prefix, such as a terminal or a debugger, may be in between.
  pid_t parent = ::getppid();
  while (isKeeper(argumentsOf(parent))) parent = parentOf(parent);
  for (pid_t process = parent; process > 0; process = parentOf(process))
    if (isRoslaunch(argumentsOf(process))) return std::make_unique<LaunchingProcess>(process);
  // No roslaunch is found: a program of the user uses the library of roslaunch. If the parent has died,
  // process 1 takes its place.
  return std::make_unique<LaunchingProcess>(parent == 1 ? 0 : parent);
}

LaunchingProcess::LaunchingProcess(pid_t process) : process_(process) {
  if (const auto stat = statOf(process)) start_ = stat->start;
}

std::string LaunchingProcess::missing() {
  const std::string who = "roslaunch (process " + std::to_string(process_) + "), which started this node, ";
  const auto stat = statOf(process_);
  if (!stat || stat->start != start_ || stat->state == 'Z' || stat->state == 'X')
    return who + "is dead: start the rig again";
  if (stat->state != 'T' && stat->state != 't') {
    stopped_since_.reset();
    return "";
  }
  if (!stopped_since_) stopped_since_ = Clock::now();
  if (Clock::now() - *stopped_since_ < silence_times::supervisor_patience) return "";
  return who + "is frozen: continue it, such as by 'kill -CONT " + std::to_string(process_) + "'";
}

std::string LaunchingProcess::server() const {
  // roslaunch runs `roslaunch -c NAME -u ADDRESS ...` on another host.
  const auto arguments = argumentsOf(process_);
  const auto at = std::find(arguments.begin(), arguments.end(), "-u");
  return at == arguments.end() || std::next(at) == arguments.end() ? "" : *std::next(at);
}

}  // namespace tactile_clay::nodes
