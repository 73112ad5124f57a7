#include "nodes/kept.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <map>
#include <mutex>

namespace tactile_clay::nodes {
namespace {

/// The pipe's descriptor; -1 if there is none.
int beatPipe() {
  const char* text = std::getenv(beat_variable);
  const int descriptor = text == nullptr ? -1 : std::atoi(text);
  struct stat status {};
  if (descriptor < 3 || ::fstat(descriptor, &status) != 0 || !S_ISFIFO(status.st_mode)) return -1;
  ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);  // child processes must give no signs of life
  return descriptor;
}

/// The nodes of this process.
struct Lives {
  using Clock = std::chrono::steady_clock;
  struct Life {
    bool beaten = false;  // since the last sign of life of the process
    Clock::time_point last;
  };
  std::mutex mutex;
  std::map<std::string, Life> nodes;
  int pipe = beatPipe();

  static Lives& ofProcess() {
    static Lives lives;
    return lives;
  }
};

}  // namespace

std::string keptFile(const std::string& node, const std::string& ending) {
  const char* folder = std::getenv(folder_variable);
  if (folder == nullptr || *folder == '\0') return "";
  std::string name = node;
  std::replace(name.begin(), name.end(), '/', '_');
  return std::string(folder) + "/" + name + ending;
}

bool isMarked(const std::string& file) {
  return !file.empty() && ::access(file.c_str(), F_OK) == 0;
}

bool mark(const std::string& file, bool marked) {
  if (file.empty()) return true;
  if (!marked) return ::unlink(file.c_str()) == 0 || errno == ENOENT;
  // The file has to outlive the process, not the computer: no wait for the disk.
  const int descriptor = ::open(file.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0644);
  return descriptor >= 0 && ::close(descriptor) == 0;
}

void beat(const std::string& node) {
  Lives& lives = Lives::ofProcess();
  const std::lock_guard<std::mutex> lock(lives.mutex);
  lives.nodes[node] = {true, Lives::Clock::now()};
  if (!std::all_of(lives.nodes.begin(), lives.nodes.end(), [](const auto& n) { return n.second.beaten; }))
    return;
  for (auto& each : lives.nodes) each.second.beaten = false;
  const ssize_t written = lives.pipe < 0 ? 0 : ::write(lives.pipe, ".", 1);
  (void)written;  // the pipe is full if nobody reads it, or not yet
}

void endOfLife(const std::string& node) {
  Lives& lives = Lives::ofProcess();
  const std::lock_guard<std::mutex> lock(lives.mutex);
  lives.nodes.erase(node);
}

std::string silentFor(double seconds) {
  Lives& lives = Lives::ofProcess();
  const std::lock_guard<std::mutex> lock(lives.mutex);
  const auto since = Lives::Clock::now() - std::chrono::duration<double>(seconds);
  std::string names;
  for (const auto& [name, life] : lives.nodes)
    if (life.last < since) names += (names.empty() ? "" : " ") + name;
  return names;
}

}  // namespace tactile_clay::nodes
