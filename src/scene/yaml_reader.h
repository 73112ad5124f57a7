#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactile_clay::scene {

/// A YAML map that is read strictly: a key that nobody asked for or that stands there twice, or a value of
/// the wrong kind, is an error with file, line and what was expected. Numbers are finite.
class YamlMap {
 public:
  YamlMap(const YAML::Node& node, std::string file) : node_(node), file_(std::move(file)) {
    if (!node_.IsMap()) fail(node_, "expected a map of keys and values");
    std::set<std::string> keys;
    for (const auto& entry : node_) {
      if (!entry.first.IsScalar()) fail(entry.first, "a key that is no name, expected keys and values");
      if (!keys.insert(entry.first.Scalar()).second)
        fail(entry.first, "key '" + entry.first.Scalar() + "' stands there twice, expected it once");
    }
  }

  bool has(const std::string& key) const { return static_cast<bool>(node_[key]); }

  /// Required value. `expected` completes "expected ...".
  template <typename T>
  T get(const std::string& key, const std::string& expected) {
    if (!has(key)) fail(node_, "key '" + key + "' is missing, expected " + expected);
    return convert<T>(key, expected);
  }
  template <typename T>
  T get(const std::string& key, const T& fallback, const std::string& expected) {
    asked_.insert(key);
    return has(key) ? convert<T>(key, expected) : fallback;
  }
  /// A number that may be `.inf`.
  double getOrInfinite(const std::string& key, double fallback, const std::string& expected) {
    asked_.insert(key);
    const double value = has(key) ? as<double>(key, expected) : fallback;
    if (std::isnan(value)) fail(node_[key], "'" + key + "' is no number, expected " + expected);
    return value;
  }
  /// Required list of exactly `count` finite numbers.
  std::vector<double> numbers(const std::string& key, std::size_t count, const std::string& expected) {
    const auto list = get<std::vector<double>>(key, expected);
    if (list.size() != count)
      fail(node_[key], "'" + key + "' has " + std::to_string(list.size()) + " numbers, expected " + expected);
    return list;
  }
  Eigen::Vector3d vector(const std::string& key, const Eigen::Vector3d& fallback,
                         const std::string& expected) {
    asked_.insert(key);
    if (!has(key)) return fallback;
    const auto list = numbers(key, 3, expected);
    return {list[0], list[1], list[2]};
  }
  /// List of maps, empty where the key is missing.
  std::vector<YamlMap> maps(const std::string& key) {
    asked_.insert(key);
    std::vector<YamlMap> result;
    if (!has(key)) return result;
    if (!node_[key].IsSequence()) fail(node_[key], "'" + key + "' expected a list");
    for (const YAML::Node& entry : node_[key]) result.emplace_back(entry, file_);
    return result;
  }
  const YAML::Node& node(const std::string& key) {
    asked_.insert(key);
    child_ = node_[key];
    return child_;
  }

  /// \throws std::runtime_error naming the first key that was never asked for
  void finish() const {
    for (const auto& entry : node_) {
      const std::string& key = entry.first.Scalar();
      if (asked_.count(key) == 0) fail(entry.first, "unknown key '" + key + "', expected one of " + known());
    }
  }

  [[noreturn]] void fail(const std::string& what) const { fail(node_, what); }
  [[noreturn]] void fail(const YAML::Node& where, const std::string& what) const {
    throw std::runtime_error(file_ + ":" + std::to_string(where.Mark().line + 1) + ": " + what);
  }

 private:
  template <typename T>
  T convert(const std::string& key, const std::string& expected) {
    const T value = as<T>(key, expected);
    if (!finite(value)) fail(node_[key], "'" + key + "' is not finite, expected " + expected);
    return value;
  }
  template <typename T>
  static bool finite(const T&) {
    return true;
  }
  static bool finite(double value) { return std::isfinite(value); }
  static bool finite(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  }
  template <typename T>
  T as(const std::string& key, const std::string& expected) {
    asked_.insert(key);
    try {
      return node_[key].as<T>();
    } catch (const YAML::Exception&) {
      fail(node_[key], "'" + key + "' cannot be read, expected " + expected);
    }
  }
  std::string known() const {
    std::string list;
    for (const std::string& key : asked_) list += (list.empty() ? "" : ", ") + key;
    return list;
  }

  YAML::Node node_, child_;
  std::string file_;
  std::set<std::string> asked_;
};

/// Reads a YAML file. \throws std::runtime_error with one line: file, line, what was expected
inline YamlMap loadYaml(const std::string& file) {
  try {
    const YAML::Node root = YAML::LoadFile(file);
    return YamlMap(root, file);
  } catch (const YAML::BadFile&) {
    throw std::runtime_error(file + ": cannot be opened, expected a readable YAML file");
  } catch (const YAML::ParserException& e) {
    throw std::runtime_error(file + ":" + std::to_string(e.mark.line + 1) + ": not YAML, " + e.msg);
  }
}

}  // namespace tactile_clay::scene
