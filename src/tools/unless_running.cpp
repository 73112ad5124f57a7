#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "nodes/ros_master.h"
#include "tools/tool_arguments.h"

namespace {

constexpr char usage[] =
    R"(Starts a program as a node, unless a node of its name runs: the master would end that node.

  unless_running PROGRAM ARGUMENTS... __name:=NAME ...

rig.launch starts each of its programs with it (launch-prefix).
)";

namespace nodes = tactile_clay::nodes;

std::string environment(const char* name, const char* fallback) {
  const char* value = std::getenv(name);
  return value == nullptr || *value == '\0' ? fallback : value;
}

/// The resolved name of the node; empty if the arguments do not contain it.
std::string nodeName(int argc, char** argv) {
  std::string name, space = environment("ROS_NAMESPACE", "/");
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("__name:=", 0) == 0) name = argument.substr(std::strlen("__name:="));
    if (argument.rfind("__ns:=", 0) == 0) space = argument.substr(std::strlen("__ns:="));
  }
  if (name.empty()) return "";
  if (space.front() != '/') space.insert(0, 1, '/');
  if (space.back() != '/') space += '/';
  return space + name;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && tactile_clay::tools::askedForHelp(argc, argv, usage)) return 0;
  if (argc < 2) {
    std::fprintf(stderr, "usage: unless_running PROGRAM ARGUMENTS...\n");
    return 1;
  }
  const std::string name = nodeName(argc, argv);
  const auto master = nodes::addressOf(environment("ROS_MASTER_URI", "http://localhost:11311"));
  if (!name.empty() && master) {
    const auto others = nodes::runningForGood(*master, {name});
    if (!others.empty()) {
      std::fprintf(stderr,
                   "tactile_clay: a node of this name runs already: %s. End it (rosnode kill %s), or start "
                   "this one in "
                   "another namespace\n",
                   others.front().words.c_str(), name.c_str());
      return 1;
    }
  }
  ::execvp(argv[1], argv + 1);
  std::fprintf(stderr, "tactile_clay: %s cannot be started: %s\n", argv[1], std::strerror(errno));
  return 1;
}
