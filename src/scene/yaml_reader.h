#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "scene/yaml_check.h"

namespace tactile_clay::scene {

/// A YAML map that is read strictly. A key that nobody asked for, a key that is there twice, or a value of
/// the wrong kind is an error with file, line and what was expected. Numbers are finite. Merge keys (`<<`)
/// give the keys that the map does not have itself.
class YamlMap {
 public:
  YamlMap(const YAML::Node& node, std::string file);

  bool has(const std::string& key) const { return find(key) != nullptr; }
  bool isList(const std::string& key) const { return has(key) && find(key)->value.IsSequence(); }
  /// Whether the key has a single value, without quotes and tag.
  bool isPlain(const std::string& key) const;
  std::vector<std::string> keys() const;
  const std::string& file() const { return file_; }

  /// Required value. `expected` completes "expected ...".
  template <typename T>
  T get(const std::string& key, const std::string& expected) {
    require(key, expected);
    return finite(key, convert<T>(key, expected), expected);
  }
  template <typename T>
  T get(const std::string& key, const T& fallback, const std::string& expected) {
    asked_.insert(key);
    return has(key) ? get<T>(key, expected) : fallback;
  }
  /// A number that may be `.inf`.
  double getOrInfinite(const std::string& key, double fallback, const std::string& expected);
  /// Required list of exactly `count` finite numbers.
  std::vector<double> numbers(const std::string& key, std::size_t count, const std::string& expected);
  Eigen::Vector3d vector(const std::string& key, const Eigen::Vector3d& fallback,
                         const std::string& expected);
  /// Required `[x, y, z, roll, pitch, yaw]`, m and rad; angles may have the tag `!degrees` or `!radians`.
  std::vector<double> pose(const std::string& key);
  /// List of maps, empty if the key is missing or has no value.
  std::vector<YamlMap> maps(const std::string& key);
  YamlMap map(const std::string& key, const std::string& expected);

  /// @throws std::runtime_error naming the first key that was never asked for
  void finish() const;

  [[noreturn]] void fail(const std::string& what) const { fail(node_, what); }
  /// The place of a key of the map, "file:line: ", for messages about it.
  std::string placeOf(const std::string& key) const;
  /// @throws std::runtime_error with the line of a key of the map
  [[noreturn]] void failAt(const std::string& key, const std::string& what) const;

 private:
  struct Entry {
    YAML::Node key, value;
  };

  [[noreturn]] void fail(const YAML::Node& where, const std::string& what) const;
  [[noreturn]] void failIn(const std::string& key, const YAML::Node& value,
                           const std::string& expected) const;
  const Entry* find(const std::string& key) const;
  void collect(const YAML::Node& map);
  void merge(const YAML::Node& key, const YAML::Node& value);
  void require(const std::string& key, const std::string& expected);
  std::string known() const;

  template <typename T>
  T convert(const std::string& key, const std::string& expected) const {
    const YAML::Node value = find(key)->value;
    if constexpr (std::is_same_v<T, std::string>)
      return text(key, value, expected);
    else if constexpr (std::is_same_v<T, std::vector<double>>)
      return list(key, value, expected);
    else
      return asNumber<T>(key, value, expected);
  }
  template <typename T>
  T asNumber(const std::string& key, const YAML::Node& value, const std::string& expected) const {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    const double number = this->number(key, value, expected);
    if constexpr (std::is_integral_v<T>) {
      // Whole numbers that a double represents exactly. No key needs larger ones.
      constexpr double maximum = 9007199254740992.0;  // 2^53
      const double low = std::max<double>(-maximum, static_cast<double>(std::numeric_limits<T>::lowest()));
      const double high = std::min<double>(maximum, static_cast<double>(std::numeric_limits<T>::max()));
      if (!(std::trunc(number) == number && number >= low && number <= high))
        failAt(key, "'" + key + "' is no whole number in its range, expected " + expected);
    }
    return static_cast<T>(number);
  }
  template <typename T>
  const T& finite(const std::string& key, const T& value, const std::string& expected) const {
    if (!isFinite(value)) failAt(key, "'" + key + "' is not finite, expected " + expected);
    return value;
  }
  template <typename T>
  static bool isFinite(const T&) {
    return true;
  }
  static bool isFinite(double value) { return std::isfinite(value); }
  static bool isFinite(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  }
  double number(const std::string& key, const YAML::Node& value, const std::string& expected,
                bool angle = false) const;
  std::string text(const std::string& key, const YAML::Node& value, const std::string& expected) const;
  std::vector<double> list(const std::string& key, const YAML::Node& value,
                           const std::string& expected) const;

  YAML::Node node_;
  std::vector<Entry> entries_;                 // in the order of the file, merged ones last
  std::map<std::string, std::size_t> places_;  // of the keys among the entries
  std::string file_;
  std::set<std::string> asked_;
};

/// Reads a YAML file of one document, in UTF-8, whose tags are known and whose aliases do not multiply.
/// @param readers with rosparam_too, each number must be the same one for rosparam
/// @throws std::runtime_error with one line: file, line, what was expected
YamlMap loadYaml(const std::string& file, YamlReaders readers = YamlReaders::own);

}  // namespace tactile_clay::scene
