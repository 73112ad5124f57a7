#include "tools/user_paths.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace tactile_clay::tools {
namespace {

namespace fs = std::filesystem;

/// Number of bytes of the UTF-8 sequence at `i`; 0 if there is none.
std::size_t sequenceLength(const std::string& text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned first = byte(i);
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  if (length == 0 || i + length > text.size()) return 0;
  for (std::size_t k = i + 1; k < i + length; ++k)
    if ((byte(k) & 0xC0U) != 0x80U) return 0;
  if (length == 3 && ((first == 0xE0 && byte(i + 1) < 0xA0) || (first == 0xED && byte(i + 1) > 0x9F)))
    return 0;
  if (length == 4 && ((first == 0xF0 && byte(i + 1) < 0x90) || (first == 0xF4 && byte(i + 1) > 0x8F)))
    return 0;
  return length;
}

/// Checks that a name can be a parameter: parameters are sent as XML.
void requireText(const std::string& name, const std::string& what) {
  std::size_t i = 0;
  while (i < name.size()) {
    const std::size_t length = sequenceLength(name, i);
    if (length == 0)
      throw std::runtime_error(what + " '" + name + "': its name is not UTF-8, so ROS cannot pass it on");
    if (length == 1 && (static_cast<unsigned char>(name[i]) < 0x20 || name[i] == 0x7F))
      throw std::runtime_error(what + " '" + name +
                               "': its name has a control character, so ROS cannot pass it on");
    i += length;
  }
}

/// Whether a file of any kind has this name. A name below a file that is no folder is not there.
/// @throws std::runtime_error if nothing can have this name, such as one that is too long
bool isThere(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0) return true;
  if (errno != ENOENT && errno != ENOTDIR)
    throw std::runtime_error("'" + path + "': " + std::strerror(errno));
  return false;
}

/// Makes a new file or a new folder, and removes it again: some folders take neither, whoever asks.
/// @throws std::runtime_error if it cannot be made
void tryToMake(const fs::path& path, bool is_folder) {
  const int made = is_folder
                       ? ::mkdir(path.c_str(), S_IRWXU)
                       : ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (made < 0)
    throw std::runtime_error("nothing can be made in folder '" + path.parent_path().string() +
                             "': " + std::strerror(errno));
  if (!is_folder) ::close(made);
  std::error_code error;
  fs::remove(path, error);
}

/// Tries whether a new file can be made, with the folders that are missing.
/// @throws std::runtime_error if it cannot
void requireMakable(const fs::path& file) {
  std::vector<fs::path> missing = {file};
  fs::path folder = file.parent_path();
  for (; !isThere(folder.string()) && folder.has_relative_path(); folder = folder.parent_path())
    missing.push_back(folder);
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw std::runtime_error("'" + folder.string() + "' is not a folder");
  // What is behind a missing folder is checked where that folder will be.
  for (const fs::path& name : missing) isThere((folder / name.filename()).string());
  tryToMake(missing.back(), missing.size() > 1);
}

/// As requireNewBag, whose errors begin with the name.
std::string newBag(const std::string& name) {
  std::error_code error;
  if (name.empty() || name.back() == '/' || fs::is_directory(name, error))
    throw std::runtime_error("is a folder, expected the name of a new bag");
  const std::string ending = ".bag";
  const bool ended =
      name.size() >= ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
  std::string bag = ended ? name : name + ending;
  const std::string active = bag + ".active";  // its name while it is recorded
  if (isThere(bag)) throw std::runtime_error("'" + bag + "' exists already, expected the name of a new bag");
  if (isThere(active))
    throw std::runtime_error(
        "'" + active + "' exists already: it is being recorded, or is incomplete and needs `rosbag reindex`");
  requireMakable(active);
  return bag;
}

}  // namespace

std::vector<std::string> argumentLines(const std::string& word) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin <= word.size()) {
    const std::size_t end = std::min(word.find('\n', begin), word.size());
    lines.push_back(word.substr(begin, end - begin));
    if (lines.size() > 1 && lines.back().find(":=") == std::string::npos)
      throw std::runtime_error("'" + word.substr(0, word.find('\n')) + "' continues on a new line '" +
                               lines.back() + "', expected a value without line breaks");
    begin = end + 1;
  }
  return lines;
}

std::string userPath(const std::string& name, const std::string& what, const std::string& here,
                     const std::string& home) {
  requireText(name, what);
  if (name.empty() || name[0] == '/') return name;
  if (name.rfind("~/", 0) == 0) {
    if (home.empty()) throw std::runtime_error(what + " '" + name + "': HOME is not set");
    return home + name.substr(1);
  }
  if (name[0] == '~')
    throw std::runtime_error(what + " '" + name + "': expected ~/ and a name in your home folder, or ./" +
                             name);
  return here + "/" + name;
}

void requireFolderToWrite(const std::string& folder) {
  try {
    tryToMake(fs::path(folder) / ("tactile_clay_" + std::to_string(::getpid()) + ".bag.active"), false);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("record: ") + error.what());
  }
}

std::string requireNewBag(const std::string& name) {
  try {
    return newBag(name);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("record '" + name + "': " + error.what());
  }
}

}  // namespace tactile_clay::tools
