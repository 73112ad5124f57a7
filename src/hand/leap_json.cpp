#include "hand/leap_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

namespace tactile_clay::hand::leap {
namespace {

std::runtime_error wrongType(const char* key, const char* expected) {
  return std::runtime_error(std::string("field ") + key + " is not " + expected);
}

// Replaces numbers of some recorders that JSON does not have by null: NaN, Infinity, and 1e999.
std::string withoutNonFinite(const std::string& text) {
  std::string clean;
  bool quoted = false;
  std::size_t i = 0;
  while (i < text.size()) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted && c == '\\' && i + 1 < text.size()) {
      clean.append(text, i, 2);
      i += 2;
      continue;
    }
    const auto wordChar = [](char w) {
      return std::isalnum(static_cast<unsigned char>(w)) != 0 || w == '-' || w == '+' || w == '.';
    };
    if (quoted || !wordChar(c)) {
      clean += c;
      ++i;
      continue;
    }
    const std::size_t end = static_cast<std::size_t>(
        std::find_if_not(text.begin() + static_cast<std::ptrdiff_t>(i), text.end(), wordChar) - text.begin());
    const std::string word = text.substr(i, end - i);
    char* rest = nullptr;
    const double value = std::strtod(word.c_str(), &rest);
    clean += *rest == '\0' && !std::isfinite(value) ? "null" : word;
    i = end;
  }
  return clean;
}

// Counts before anything is built, because a text of 4 MB can need 600 MB.
void requireWithin(const std::string& text, const Limits& limits) {
  const auto require = [](std::size_t found, const char* what, std::size_t maximum) {
    if (found > maximum)
      throw std::runtime_error("has " + std::string(what) + " of " + std::to_string(found) +
                               ", expected at most " + std::to_string(maximum));
  };
  require(text.size(), "a length in bytes", limits.bytes);
  std::size_t values = 1, depth = 0, deepest = 0;
  bool quoted = false, escaped = false;
  for (const char c : text) {
    if (escaped) {
      escaped = false;
    } else if (quoted && c == '\\') {
      escaped = true;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted) {
      const bool opens = c == '[' || c == '{';
      values += opens || c == ',' ? 1 : 0;
      if (opens) deepest = std::max(deepest, ++depth);
      if ((c == ']' || c == '}') && depth > 0) --depth;
    }
  }
  require(values, "a number of values", limits.values);
  require(deepest, "a depth", limits.depth);
}

double numberOf(const Json& value, const char* key) {
  if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!value.is_number()) throw wrongType(key, "a number");
  return value.get<double>();
}

const Json* find(const Json& object, const char* key) {
  if (!object.is_object())
    throw std::runtime_error(std::string("has something that is not an object where ") + key +
                             " was looked for");
  const auto field = object.find(key);
  return field == object.end() ? nullptr : &*field;
}

/// The value of the key, which must have the type of `none`. If there is no such key, `none`.
const Json& childOf(const Json& parent, const char* key, const Json& none, const char* expected) {
  const Json* value = find(parent, key);
  if (value == nullptr) return none;
  if (value->type() != none.type()) throw wrongType(key, expected);
  return *value;
}

}  // namespace

Json parse(const std::string& text, const Limits& limits) {
  requireWithin(text, limits);
  Json message = Json::parse(text, nullptr, false);
  if (message.is_discarded()) message = Json::parse(withoutNonFinite(text), nullptr, false);
  if (message.is_discarded()) throw std::runtime_error("is not JSON");
  return message;
}

std::optional<double> number(const Json& object, const char* key) {
  const Json* value = find(object, key);
  if (value == nullptr) return std::nullopt;
  return numberOf(*value, key);
}

std::optional<Eigen::Vector3d> vector(const Json& object, const char* key) {
  const Json* value = find(object, key);
  if (value == nullptr || value->is_null()) return std::nullopt;
  if (!value->is_array() || value->size() != 3) throw wrongType(key, "an array of three numbers");
  return Eigen::Vector3d(numberOf((*value)[0], key), numberOf((*value)[1], key), numberOf((*value)[2], key));
}

bool flag(const Json& object, const char* key, bool fallback) {
  const Json* value = find(object, key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) throw wrongType(key, "true or false");
  return value->get<bool>();
}

const Json& object(const Json& parent, const char* key) {
  static const Json none = Json::object();
  return childOf(parent, key, none, "an object");
}

const Json& array(const Json& object, const char* key) {
  static const Json none = Json::array();
  return childOf(object, key, none, "an array");
}

std::string id(const Json& object, const char* key) {
  const Json* value = find(object, key);
  if (value == nullptr || value->is_null()) return {};
  if (value->is_string()) return value->get<std::string>();
  if (value->is_number_integer()) return value->dump();
  throw wrongType(key, "a whole number or a string");
}

std::string handType(const Json& hand) {
  const Json* value = find(hand, "type");
  if (value == nullptr || value->is_null()) return {};
  if (!value->is_string()) throw wrongType("type", "left or right");
  return value->get<std::string>();
}

int fingerType(const Json& pointable) {
  const Json* tool = find(pointable, "tool");
  if (tool != nullptr && tool->is_boolean() && tool->get<bool>()) return -1;
  if (const auto type = number(pointable, "type"); type && !std::isnan(*type)) {
    if (!(*type >= 0.0 && *type <= 4.0)) throw wrongType("type", "0 to 4");
    return static_cast<int>(*type);
  }
  const std::string own = id(pointable, "id");
  if (own.empty() || own.back() < '0' || own.back() > '4')
    throw wrongType("id", "one that ends with the finger 0 to 4");
  return own.back() - '0';
}

std::chrono::nanoseconds timestamp(const Json& frame) {
  // us, a hundred days. The limit below is 1e3 times this, about the most that int64 can store in ns.
  constexpr double latest = 9e12;
  const auto microseconds = number(frame, "timestamp");
  if (!microseconds || !(*microseconds >= 0.0 && *microseconds < 1e3 * latest))
    throw wrongType("timestamp", "a time in microseconds");
  return std::chrono::nanoseconds(std::llround(*microseconds) * 1000);
}

}  // namespace tactile_clay::hand::leap
