#include "scene/xacro.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "files/ends_with.h"
#include "files/input_file.h"
#include "scene/text_file.h"

namespace tactile_clay::scene {
namespace {

constexpr char patience[] = "20";  // s
// Bytes of addresses; for a small model xacro has 20 MB.
constexpr std::uint64_t max_memory = files::gibibyte;
// Bytes of each file that xacro writes. One byte more than a text may have tells that there was more.
constexpr std::uint64_t max_output = files::maximum::text + 1;
constexpr int timed_out = 124;  // exit code of the program `timeout` after it has killed a program

using Stream = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

Stream temporary() {
  Stream file(std::tmpfile(), &std::fclose);
  if (!file) throw std::runtime_error("no temporary file for what xacro says");
  return file;
}

/// @throws std::runtime_error if there is more than a text may have
std::string textOf(std::FILE* file) {
  std::string text, piece(std::size_t{1} << 16, '\0');
  std::rewind(file);
  for (std::size_t n = 0;
       (n = std::fread(&piece[0], 1, piece.size(), file)) > 0 && text.size() <= files::maximum::text;)
    text.append(piece, 0, n);
  if (text.size() > files::maximum::text)
    throw std::runtime_error("what xacro writes is too large, expected at most " +
                             std::to_string(files::maximum::text / files::mebibyte) + " MiB");
  return text;
}

bool isThere(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  return false;
}

/// Runs a program without a shell.
/// @return its exit code
int run(const std::vector<std::string>& words, std::FILE* out, std::FILE* err) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, fileno(out), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(err), STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("xacro cannot be started: " + std::string(std::strerror(error)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

std::string withoutComments(const std::string& xml) {
  std::string text;
  std::size_t from = 0;
  while (from < xml.size()) {
    const std::size_t begin = std::min(xml.find("<!--", from), xml.size());
    text.append(xml, from, begin - from);
    const std::size_t end = xml.find("-->", begin);
    from = end == std::string::npos ? xml.size() : end + 3;
  }
  return text;
}

}  // namespace

bool hasMacros(const std::string& text, const std::string& file) {
  const std::string xml = withoutComments(text);
  const auto has = [&](const char* words) { return xml.find(words) != std::string::npos; };
  return files::endsWith(file, ".xacro") || has("<xacro:") ||
         (has("xmlns:xacro") && (has("${") || has("$(")));
}

std::string expandMacros(const std::string& file) {
  if (!isThere("xacro"))
    throw std::runtime_error(
        "is written with macros, and the program xacro that expands them is not there: install xacro, or "
        "name a plain URDF");
  const Stream out = temporary(), err = temporary();
  const int code =
      run({"prlimit", "--as=" + std::to_string(max_memory), "--core=0",
           "--fsize=" + std::to_string(max_output), "timeout", "-k", "1", patience, "xacro", file},
          out.get(), err.get());
  if (code == timed_out) throw std::runtime_error("xacro takes longer than " + std::string(patience) + " s");
  std::string made = textOf(out.get());  // too much is the reason for any code
  if (code != 0) {
    std::string said = oneLine(textOf(err.get()));
    constexpr std::size_t enough = 300;
    if (said.size() > enough) said = "..." + said.substr(said.size() - enough);  // the cause is at the end
    // xacro does not say by itself that it ran out of memory.
    throw std::runtime_error("xacro (at most " + std::to_string(max_memory / files::mebibyte) +
                             " MiB of memory) ends with code " + std::to_string(code) + ": " + said);
  }
  return made;
}

}  // namespace tactile_clay::scene
