#pragma once

#include <algorithm>
#include <chrono>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "safety/silence_times.h"
#include "values/text.h"

namespace tactile_clay::device {

/// The options in a text of words key=value. A word without a '=' belongs to the value before it, as the
/// numbers of a pose do.
/// @param where name of the parameter or argument, for errors
/// @throws std::runtime_error with one line if the first word has no key
inline std::map<std::string, std::string> optionsOf(const std::string& where, const std::string& text) {
  std::map<std::string, std::string> options;
  std::istringstream words(text);
  std::string word, key;
  while (words >> word) {
    const std::size_t at = word.find('=');
    if (at != std::string::npos && at > 0) {
      key = word.substr(0, at);
      options[key] = word.substr(at + 1);
    } else if (!key.empty()) {
      options[key] += " " + word;
    } else {
      throw std::runtime_error(where + ": '" + text + "', expected key=value ...");
    }
  }
  return options;
}

/// @param where name of the parameter or argument, for errors
/// @throws std::runtime_error with one line if the temperature is among the options: it is a parameter of the
/// node, because the safety gate needs the same value
inline void requireNoTemperature(const std::string& where,
                                 const std::map<std::string, std::string>& options) {
  if (options.count("temperature") > 0)
    throw std::runtime_error(
        where +
        ": has the option temperature, expected it as parameter 'temperature' of the node, for the "
        "device and its safety gate");
}

/// Options of devices are texts. These functions read one, or return `fallback` if it is not set or empty.

/// @throws std::runtime_error naming the option, its value and what was expected
inline std::string choice(const std::map<std::string, std::string>& options, const std::string& device,
                          const std::string& key, const std::string& fallback,
                          const std::vector<std::string>& allowed) {
  const auto given = options.find(key);
  std::string value = given == options.end() || given->second.empty() ? fallback : given->second;
  std::string list;
  for (const std::string& one : allowed) {
    if (value == one) return value;
    list += (list.empty() ? "" : ", ") + one;
  }
  throw std::runtime_error(device + ": " + key + " is '" + value + "', expected one of " + list);
}

/// Numbers, separated by spaces.
/// @throws std::runtime_error as choice
inline std::vector<double> numbers(const std::map<std::string, std::string>& options,
                                   const std::string& device, const std::string& key,
                                   const std::vector<double>& fallback, double low, double high) {
  const auto given = options.find(key);
  if (given == options.end() || given->second.empty()) return fallback;
  const auto all = values::numbersOf(given->second);
  if (!all || all->size() != fallback.size() ||
      !std::all_of(all->begin(), all->end(), [&](double x) { return x >= low && x <= high; })) {
    std::ostringstream line;
    line << device << ": " << key << " is '" << given->second << "', expected " << fallback.size()
         << (fallback.size() == 1 ? " number from " : " numbers from ") << low << " to " << high;
    throw std::runtime_error(line.str());
  }
  return *all;
}

/// A single number.
/// @throws std::runtime_error as choice
inline double number(const std::map<std::string, std::string>& options, const std::string& device,
                     const std::string& key, double fallback, double low, double high) {
  return numbers(options, device, key, {fallback}, low, high).front();
}

/// The option `hold`: s after which a device goes silent by itself if its emission is not renewed.
/// @throws std::runtime_error as choice
inline std::chrono::duration<double> holdOf(const std::map<std::string, std::string>& options,
                                            const std::string& device) {
  constexpr double usual = silence_times::seconds(silence_times::device_hold);
  return std::chrono::duration<double>(number(options, device, "hold", usual, 0.02, 10.0));
}

}  // namespace tactile_clay::device
