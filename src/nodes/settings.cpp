#include "nodes/settings.h"

#include <algorithm>
#include <stdexcept>

#include "nodes/params.h"
#include "values/range.h"

namespace tactile_clay::nodes {

const char* kindOf(const SettingValue& value) {
  return std::visit([](const auto& v) { return kindOfParam<std::decay_t<decltype(v)>>(); }, value);
}

Settings::Settings(const ros::NodeHandle& private_nh)
    : server_(private_nh),
      naming_([private_nh](const std::string& name) { return "parameter " + private_nh.resolveName(name); }) {
}

Settings::Settings(Naming naming, SettingValues given)
    : naming_(std::move(naming)), given_(std::move(given)) {}

template <typename T>
T Settings::take(const std::string& name, const T& fallback) const {
  if (server_) return param(*server_, name, fallback);
  const auto found = given_.find(name);
  if (found == given_.end()) return fallback;
  if constexpr (std::is_same_v<T, double>)
    if (const int* whole = std::get_if<int>(&found->second)) return *whole;
  if (const T* value = std::get_if<T>(&found->second)) return *value;
  throw std::runtime_error(naming_(name) + ": expected " + kindOfParam<T>());
}

template <typename T>
T Settings::within(Setting setting) {
  const T value = take(setting.name, std::get<T>(setting.fallback));
  values::requireIn<std::runtime_error>(naming_(setting.name), value, std::get<T>(setting.low),
                                        std::get<T>(setting.high));
  setting.value = value;
  setting.group = group_;
  read_.push_back(std::move(setting));
  return value;
}

double Settings::number(const std::string& name, double fallback, double low, double high,
                        const std::string& meaning) {
  return within<double>({name, "", meaning, fallback, fallback, low, high, {}});
}

int Settings::whole(const std::string& name, int fallback, int low, int high, const std::string& meaning) {
  return within<int>({name, "", meaning, fallback, fallback, low, high, {}});
}

bool Settings::truth(const std::string& name, bool fallback, const std::string& meaning) {
  const bool value = take(name, fallback);
  read_.push_back({name, group_, meaning, value, fallback, false, true, {}});
  return value;
}

std::string Settings::text(const std::string& name, const std::string& fallback, const std::string& meaning,
                           const std::vector<std::string>& choices) {
  const std::string value = take(name, fallback);
  if (!choices.empty() && std::find(choices.begin(), choices.end(), value) == choices.end()) {
    std::string list;
    for (const std::string& choice : choices) list += (list.empty() ? "" : ", ") + choice;
    throw std::runtime_error(naming_(name) + ": expected one of " + list + ", got '" + value + "'");
  }
  read_.push_back({name, group_, meaning, value, fallback, std::string(), std::string(), choices});
  return value;
}

SettingValues Settings::values() const {
  SettingValues values;
  for (const Setting& setting : read_) values[setting.name] = setting.value;
  return values;
}

}  // namespace tactile_clay::nodes
