#include "scene/rosparam_number.h"

#include <algorithm>
#include <cstdio>
#include <regex>

#include "values/text.h"

namespace tactile_clay::scene {
namespace {

constexpr std::size_t longest = 40;  // characters of a number; std::regex needs stack for each

bool matches(const std::string& text, const std::regex& pattern) {
  return text.size() <= longest && std::regex_match(text, pattern);
}

/// Whether a text is meant as one number: a sign or a point may come before its first digit.
bool beginsAsNumber(const std::string& text) {
  std::size_t at = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  if (at < text.size() && text[at] == '.') ++at;
  return at < text.size() && text[at] >= '0' && text[at] <= '9' &&
         text.find_first_of(" \t\r\n") == std::string::npos;
}

bool isAngle(const std::string& text) {
  return (text.compare(0, 4, "deg(") == 0 || text.compare(0, 4, "rad(") == 0) && text.back() == ')';
}

/// A number as both readers read it.
std::string written(double number) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.15g", number);
  std::string text = buffer;
  // printf writes the sign of the exponent; the point is missing before it, and in a large whole number.
  if (text.find('.') == std::string::npos && !isRosparamWhole(text))
    text.insert(std::min(text.find('e'), text.size()), ".0");
  return text;
}

}  // namespace

bool isRosparamWhole(const std::string& text) {
  static const std::regex whole("[-+]?(0|[1-9][0-9]{0,8})");
  return matches(text, whole);
}

bool isRosparamNumber(const std::string& text) {
  static const std::regex real("([-+]?[0-9]+\\.[0-9]*|\\.[0-9]+)([eE][-+][0-9]+)?");
  return isRosparamWhole(text) || matches(text, real);
}

std::string faultForRosparam(const std::string& text, bool plain) {
  const bool number = beginsAsNumber(text);
  if (!number && !isAngle(text)) return "";
  if (plain && (!number || isRosparamNumber(text))) return "";
  std::string better = text;
  if (number) {
    const auto numbers = values::numbersOf(text);
    better = numbers && numbers->size() == 1 ? written(numbers->front()) : "a number such as 0.3";
  }
  return "'" + text.substr(0, longest) + "' is something else for rosparam, write " + better +
         ", without quotes or tag";
}

}  // namespace tactile_clay::scene
