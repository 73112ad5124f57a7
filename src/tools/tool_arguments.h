#pragma once

#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "values/text.h"

namespace tactile_clay::tools {

/// The number that a text contains.
/// @param name of the argument, for errors
/// @throws std::runtime_error if the text is not a number from low to high
inline double numberOf(const std::string& name, const std::string& text, double low, double high) {
  std::istringstream stream(text);
  double number = 0.0;
  if (!(stream >> number) || !(stream >> std::ws).eof() || !(number >= low && number <= high)) {
    std::ostringstream line;
    line << name << " '" << text << "': expected a number from " << low << " to " << high;
    throw std::runtime_error(line.str());
  }
  return number;
}

/// As `numberOf`, for whole numbers, which may be written as 16.0 or 1e1.
inline int wholeOf(const std::string& name, const std::string& text, int low, int high) {
  const double number = numberOf(name, text, low, high);
  if (number != std::floor(number))
    throw std::runtime_error(name + " '" + text + "': expected a whole number");
  return static_cast<int>(number);
}

/// The value of a key, or `fallback` if there is none.
inline std::string valueOf(const std::map<std::string, std::string>& values, const std::string& key,
                           const std::string& fallback) {
  const auto found = values.find(key);
  return found == values.end() ? fallback : found->second;
}

/// Prints the usage if one of the arguments is `--help` or `-h`.
/// @return whether it did
inline bool askedForHelp(int argc, char** argv, const char* usage) {
  for (int k = 1; k < argc; ++k)
    if (argv[k] == std::string("--help") || argv[k] == std::string("-h"))
      return std::printf("%s", usage) >= 0;
  return false;
}

/// The main function of a tool. `--help` or `-h` prints the usage. An exception of `run` is printed in one
/// line, with the tool's name, and the exit code is 1. Its text may have names out of files, so it is made
/// printable.
/// @param run returns the exit code, or nothing
template <typename Run>
int runTool(const char* name, const char* usage, int argc, char** argv, const Run& run) {
  try {
    if (askedForHelp(argc, argv, usage)) return 0;
    if constexpr (std::is_void_v<decltype(run())>)
      run();
    else
      return run();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name,
                 values::printableLine(error.what(), values::longest_last_line).c_str());
    return 1;
  }
}

/// Arguments "key:=value" of a program, as roslaunch has them. Every key must be known.
class Arguments {
 public:
  /// @param known keys and their default values
  /// @throws std::runtime_error naming an argument that is not known
  Arguments(int argc, char** argv, std::map<std::string, std::string> known) : values_(std::move(known)) {
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      const std::size_t at = argument.find(":=");
      const auto found = values_.find(argument.substr(0, at));
      if (at == std::string::npos || found == values_.end()) {
        std::string expected;
        for (const auto& [key, value] : values_) expected += (expected.empty() ? "" : ", ") + key + ":=";
        throw std::runtime_error("unknown argument '" + argument + "', expected " + expected);
      }
      found->second = argument.substr(at + 2);
    }
  }

  const std::string& operator[](const std::string& key) const { return values_.at(key); }

  double number(const std::string& key, double low, double high) const {
    return numberOf(key, values_.at(key), low, high);
  }

  bool flag(const std::string& key) const {
    const std::string& value = values_.at(key);
    if (value != "true" && value != "false")
      throw std::runtime_error(key + " '" + value + "': expected true or false");
    return value == "true";
  }

 private:
  std::map<std::string, std::string> values_;
};

}  // namespace tactile_clay::tools
