#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

/// Fields of Leap v6 messages. A missing field is std::nullopt, as is a vector that is null; a number that
/// cannot be one (NaN, or the null that JSON makes of it) is NaN, and a field of another type throws
/// std::runtime_error that names it.
namespace tactile_clay::hand::leap {

using Json = nlohmann::json;

/// Maxima of a message; a frame of two hands has 20 kB, 900 values, and is 6 deep.
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

/// @param fallback where it is missing
bool flag(const Json& object, const char* key, bool fallback);

/// An object, empty where it is missing.
const Json& object(const Json& parent, const char* key);

/// An array, empty where it is missing.
const Json& array(const Json& object, const char* key);

/// Ids are numbers in some services and strings in others.
/// @return digits; empty if missing
std::string id(const Json& object, const char* key);

/// "left", "right", what else it says, or empty if missing.
std::string handType(const Json& hand);

/// Finger 0 (thumb) to 4 of a pointable, by its type or else by its id; -1 for a tool.
int fingerType(const Json& pointable);

/// Time of a frame by the device clock, from microseconds.
std::chrono::nanoseconds timestamp(const Json& frame);

}  // namespace tactile_clay::hand::leap
