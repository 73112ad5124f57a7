#include "nodes/exit_code.h"

#include <ros/init.h>

#include <atomic>

namespace tactile_clay::nodes {
namespace {
std::atomic<int> code_of_process{0};
}

void finish(int code) {
  int before = code_of_process;
  while (before < code && !code_of_process.compare_exchange_weak(before, code)) {
  }
  ros::requestShutdown();
}

bool shuttingDown() {
  return !ros::ok() || ros::isShuttingDown();
}

int exitCode() {
  return code_of_process;
}

}  // namespace tactile_clay::nodes
