#include "device/sonic_surface_corrections.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "device/sonic_surface_protocol.h"
#include "files/input_file.h"

namespace tactile_clay::device::sonic_surface {
namespace {

constexpr char header[] = "channel,turns";

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("sonic_surface: corrections '" + path + "': " + what);
}

std::string readAll(const std::string& path) {
  try {
    return files::readWhole(path, files::maximum::text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("sonic_surface: corrections: ") + error.what());
  }
}

/// The number that the whole text is.
/// @return nothing if the text is no number
std::optional<double> numberIn(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<double> ofTable(const std::string& path, const std::string& text) {
  std::vector<double> turns(channels, std::nan(""));
  std::istringstream lines(text);
  std::string line;
  bool begun = false;
  for (int count = 1; std::getline(lines, line); ++count) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const auto expected = [&](const std::string& what) {
      fail(path, "line " + std::to_string(count) + " is '" + line.substr(0, 60) + "', expected " + what);
    };
    if (!begun) {
      if (line != header) expected(std::string("the header ") + header);
      begun = true;
      continue;
    }
    const std::size_t comma = line.find(',');
    if (comma == std::string::npos) expected("channel,turns");
    const std::optional<double> channel = numberIn(line.substr(0, comma));
    const std::string word = line.substr(comma + 1);
    const std::optional<double> value = word == "flipped" ? 0.5 : numberIn(word);
    if (!channel || *channel < 0 || *channel >= channels || *channel != std::floor(*channel))
      expected("a channel from 0 to 255");
    if (!value || std::abs(*value) > 1.0) expected("turns from -1 to 1, or flipped");
    double& entry = turns[static_cast<std::size_t>(*channel)];
    if (!std::isnan(entry)) expected("each channel once");
    entry = *value;
  }
  const auto missing = std::find_if(turns.begin(), turns.end(), [](double x) { return std::isnan(x); });
  if (missing != turns.end())
    fail(path, "has no channel " + std::to_string(missing - turns.begin()) + ", expected all from 0 to 255");
  return turns;
}

std::vector<double> ofFirmware(const std::string& path, const std::string& text) {
  const std::string expected = "expected a constant PHASE_CORRECTION of 256 numbers from 0 to 32";
  const std::size_t name = text.find("constant PHASE_CORRECTION");
  const std::size_t begin = name == std::string::npos ? name : text.find('(', name);
  const std::size_t end = begin == std::string::npos ? begin : text.find(')', begin);
  if (end == std::string::npos) fail(path, "has no PHASE_CORRECTION, " + expected);
  std::istringstream numbers(text.substr(begin + 1, end - begin - 1));
  std::vector<double> turns;
  for (std::string word; std::getline(numbers, word, ',');) {
    word.erase(std::remove_if(word.begin(), word.end(), [](unsigned char c) { return std::isspace(c) != 0; }),
               word.end());
    const std::optional<double> value = numberIn(word);
    if (!value || *value < 0.0 || *value > 32.0)
      fail(path, "PHASE_CORRECTION has '" + word.substr(0, 20) + "', " + expected);
    turns.push_back(*value / 32.0);
  }
  if (turns.size() != channels)
    fail(path, "PHASE_CORRECTION has " + std::to_string(turns.size()) + " numbers, " + expected);
  return turns;
}

}  // namespace

std::vector<double> readCorrections(const std::string& path) {
  const std::string text = readAll(path);
  return std::filesystem::path(path).extension() == ".vhd" ? ofFirmware(path, text) : ofTable(path, text);
}

std::vector<double> addedPhases(const std::map<std::string, std::string>& options, std::size_t boards) {
  std::vector<double> added;
  const auto add = [&](const char* key, std::size_t board, double factor) {
    const auto given = options.find(key);
    if (given == options.end() || given->second.empty() || given->second == "none") return;
    if (board >= boards)
      throw std::runtime_error("sonic_surface: " + std::string(key) + " is '" + given->second +
                               "', expected it with boards=2 only");
    const std::vector<double> turns = readCorrections(given->second);
    added.resize(boards * channels, 0.0);
    for (std::size_t n = 0; n < turns.size(); ++n) added[board * turns.size() + n] += factor * turns[n];
  };
  add("corrections", 0, 1.0);
  add("second_corrections", 1, 1.0);
  for (std::size_t board = 0; board < boards; ++board) add("firmware_corrections", board, -1.0);
  return added;
}

}  // namespace tactile_clay::device::sonic_surface
