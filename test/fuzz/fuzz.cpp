#include "fuzz/fuzz.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace tactile_clay::fuzz {
namespace {

constexpr std::size_t longest_line = 2000;  // characters

[[noreturn]] void end(const std::string& why) {
  std::fprintf(stderr, "fuzz: %s\n", why.c_str());
  std::abort();
}

/// A file in memory, for some thousand of them on a disk take longer than the parsers.
int memory() {
  const int file = ::memfd_create("fuzz", 0);
  if (file < 0) end("no file in memory");
  return file;
}

}  // namespace

std::string asFile(const std::uint8_t* data, std::size_t size) {
  static const int file = memory();
  if (::ftruncate(file, 0) != 0 || ::pwrite(file, data, size, 0) != static_cast<ssize_t>(size))
    end("a file in memory that cannot be written");
  return "/proc/self/fd/" + std::to_string(file);
}

std::string readFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) end("no file " + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void expectOneLine(const std::string& line) {
  if (line.empty()) end("a refusal without a reason");
  if (line.find('\n') != std::string::npos) end("a refusal of more than one line: " + line);
  if (line.size() > longest_line) end("a refusal of " + std::to_string(line.size()) + " characters");
}

}  // namespace tactile_clay::fuzz
