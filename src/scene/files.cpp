#include "scene/files.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "scene/text_file.h"

namespace tactile_clay::scene {
namespace {

namespace fs = std::filesystem;

/// Removes `start` from the beginning of a text; returns false if the text does not start so.
bool takeStart(std::string& text, const std::string& start) {
  if (text.compare(0, start.size(), start) != 0) return false;
  text.erase(0, start.size());
  return true;
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// A text with its codes such as %20 decoded.
std::string decoded(const std::string& address) {
  std::string text;
  std::size_t k = 0;
  while (k < address.size()) {
    const bool coded = address[k] == '%' && k + 2 < address.size() && hexDigit(address[k + 1]) >= 0 &&
                       hexDigit(address[k + 2]) >= 0;
    text += coded ? static_cast<char>(16 * hexDigit(address[k + 1]) + hexDigit(address[k + 2])) : address[k];
    k += coded ? 3 : 1;
  }
  return text;
}

/// The path as it is written if there is such a file, otherwise decoded like an address.
fs::path writtenOrDecoded(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored) ? fs::path(path) : fs::path(decoded(path));
}

/// Names of the files of a folder, for error messages.
std::string namesIn(const fs::path& folder, const std::string& ending) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ending) names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

bool isFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

}  // namespace

fs::path pathOf(const std::string& name, const fs::path& folder, const FindPackage& find_package) {
  const auto fail = [&](const std::string& what) {
    throw std::runtime_error(oneLine("'" + name + "': " + what));
  };
  std::string rest = name;
  if (takeStart(rest, "package://")) {
    const std::string package = rest.substr(0, rest.find('/'));
    const std::string found = find_package ? find_package(package) : "";
    if (found.empty()) fail("package '" + package + "' is not known, expected one of ROS_PACKAGE_PATH");
    return writtenOrDecoded(found + rest.substr(package.size()));
  }
  if (takeStart(rest, "file://")) return writtenOrDecoded(rest);
  if (name.find("://") != std::string::npos) fail("expected a path, file:// or package://");
  if (takeStart(rest, "~/")) {
    const char* home = std::getenv("HOME");
    if (home == nullptr) fail("HOME is not set");
    return fs::path(home) / rest;
  }
  return folder / name;
}

std::string findFile(const std::string& kind, const std::string& name, const fs::path& beside,
                     const fs::path& shipped, const std::string& ending, const FindPackage& find_package) {
  const auto fail = [&](const std::string& what) {
    throw std::runtime_error(oneLine(
        kind + " '" + name + "' not found, expected a file or one of: " + namesIn(shipped, ending) + what));
  };
  if (name.empty()) fail("");
  const fs::path path = pathOf(name, beside, find_package);
  if (isFile(path)) return path.string();
  if (name.find('/') != std::string::npos) fail("; there is no file " + path.string());
  // A material of the same name may lie beside a scene: a name without an ending is first looked for in the
  // package.
  for (const fs::path& file : {shipped / (name + ending), beside / (name + ending), shipped / name})
    if (isFile(file)) return file.string();
  fail(beside.empty() ? "" : "; it is not in " + beside.string() + " either");
  return "";
}

}  // namespace tactile_clay::scene
