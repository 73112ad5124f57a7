#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

/// Fields of Leap v6 messages. A missing field is std::nullopt, and so is a vector that is null. A number
/// that is null is NaN, because JSON has no NaN. A field of another type throws std::runtime_error naming it.
namespace tactile_clay::hand::leap {

using Json = nlohmann::json;

/// Maxima of a message. A frame of two hands has 20 kB and 900 values, and is 6 levels deep.
struct Limits {
  std::size_t bytes = 1U << 20U;
  std::size_t values = 50'000;  // each may cost a hundred bytes of memory
  std::size_t depth = 32;
};

/// Parses one message; accepts NaN and Infinity, which some recorders write, as null.
/// @throws std::runtime_error with one line
Json parse(const std::string& text, const Limits& limits = {});

std::optional<double> number(const Json& object, const char* key);
std::optional<Eigen::Vector3d> vector(const Json& object, const char* key);

/// @param fallback value if the field is missing
bool flag(const Json& object, const char* key, bool fallback);

/// An object; empty if it is missing.
const Json& object(const Json& parent, const char* key);

/// An array; empty if it is missing.
const Json& array(const Json& object, const char* key);

/// An id. Some services write numbers, others strings.
/// @return digits; empty if missing
std::string id(const Json& object, const char* key);

/// "left", "right", another text of the field, or empty if it is missing.
std::string handType(const Json& hand);

/// Finger 0 (thumb) to 4 of a pointable, by its type or else by its id; -1 for a tool.
int fingerType(const Json& pointable);

/// Time of a frame by the device clock, from microseconds.
std::chrono::nanoseconds timestamp(const Json& frame);

}  // namespace tactile_clay::hand::leap
