#include "scene/yaml_reader.h"

#include <locale>
#include <sstream>

#include "scene/text_file.h"

namespace tactile_clay::scene {
namespace {

constexpr char merge_key[] = "<<";
constexpr double degree = M_PI / 180.0;  // rad

std::string nameOfTag(const YAML::Node& node) {
  return isPlainTag(node.Tag()) ? "" : "tag '" + node.Tag() + "' at ";
}

/// A number as YAML writes them, in any locale.
/// @return whether it is one
bool readNumber(const std::string& text, double& number) {
  const std::size_t sign = text.empty() || (text[0] != '-' && text[0] != '+') ? 0 : 1;
  const std::string rest = text.substr(sign);
  number = 0.0;
  if (rest == ".inf" || rest == ".Inf" || rest == ".INF")
    number = INFINITY;
  else if (sign == 0 && (rest == ".nan" || rest == ".NaN" || rest == ".NAN"))
    number = NAN;
  else {
    if (rest.find_first_not_of("0123456789.eE+-") != std::string::npos) return false;
    std::istringstream stream(rest);
    stream.imbue(std::locale::classic());
    if (rest.empty() || rest[0] == '-' || rest[0] == '+' || !(stream >> number) || stream.peek() != EOF)
      return false;
  }
  if (sign == 1 && text[0] == '-') number = -number;
  return true;
}

}  // namespace

YamlMap::YamlMap(const YAML::Node& node, std::string file) : node_(node), file_(std::move(file)) {
  if (node_.IsNull()) throw std::runtime_error(file_ + ": is empty, expected a map of keys and values");
  collect(node_);
}

/// Adds the keys of a map that are not there yet.
void YamlMap::collect(const YAML::Node& map) {
  if (!map.IsMap()) fail(map, "expected a map of keys and values");
  std::set<std::string> own;
  std::vector<Entry> merges;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) fail(entry.first, "a key that is no name, expected keys and values");
    const std::string& key = entry.first.Scalar();
    if (!isPlainTag(entry.first.Tag())) fail(entry.first, nameOfTag(entry.first) + "a key, expected none");
    if (!own.insert(key).second) fail(entry.first, "key '" + key + "' stands there twice, expected it once");
    if (key == merge_key && entry.first.Tag() != "!")  // a quoted key has the tag "!"
      merges.push_back({entry.first, entry.second});
    else if (places_.emplace(key, entries_.size()).second)
      entries_.push_back({entry.first, entry.second});
  }
  for (const Entry& entry : merges) merge(entry.key, entry.value);
}

void YamlMap::merge(const YAML::Node& key, const YAML::Node& value) {
  const auto one = [&](const YAML::Node& map) {
    if (!map.IsMap()) fail(key, "merge key '<<' of what is no map, expected a map or a list of maps");
    collect(map);
  };
  if (!value.IsSequence()) return one(value);
  for (const YAML::Node& map : value) one(map);
}

const YamlMap::Entry* YamlMap::find(const std::string& key) const {
  const auto found = places_.find(key);
  return found == places_.end() ? nullptr : &entries_[found->second];
}

bool YamlMap::isPlain(const std::string& key) const {
  const Entry* entry = find(key);
  return entry != nullptr && entry->value.IsScalar() && hasNoTag(entry->value.Tag());
}

std::vector<std::string> YamlMap::keys() const {
  std::vector<std::string> list;
  for (const Entry& entry : entries_) list.push_back(entry.key.Scalar());
  return list;
}

void YamlMap::require(const std::string& key, const std::string& expected) {
  asked_.insert(key);
  const Entry* entry = find(key);
  if (entry == nullptr) fail(node_, "key '" + key + "' is missing, expected " + expected);
  if (entry->value.IsNull()) failAt(key, "'" + key + "' has no value, expected " + expected);
}

double YamlMap::getOrInfinite(const std::string& key, double fallback, const std::string& expected) {
  asked_.insert(key);
  if (!has(key)) return fallback;
  require(key, expected);
  const double value = convert<double>(key, expected);
  if (std::isnan(value)) failAt(key, "'" + key + "' is no number, expected " + expected);
  return value;
}

std::vector<double> YamlMap::numbers(const std::string& key, std::size_t count, const std::string& expected) {
  auto list = get<std::vector<double>>(key, expected);
  if (list.size() != count)
    failAt(key, "'" + key + "' has " + std::to_string(list.size()) + " numbers, expected " + expected);
  return list;
}

Eigen::Vector3d YamlMap::vector(const std::string& key, const Eigen::Vector3d& fallback,
                                const std::string& expected) {
  asked_.insert(key);
  if (!has(key)) return fallback;
  const auto list = numbers(key, 3, expected);
  return {list[0], list[1], list[2]};
}

std::vector<double> YamlMap::pose(const std::string& key) {
  const std::string expected = "x y z (m) roll pitch yaw (rad)";
  require(key, expected);
  const YAML::Node value = find(key)->value;
  if (!value.IsSequence() || !isPlainTag(value.Tag())) failIn(key, value, expected);
  if (value.size() != 6)
    failAt(key, "'" + key + "' has " + std::to_string(value.size()) + " numbers, expected " + expected);
  std::vector<double> numbers;
  for (const YAML::Node& element : value)
    numbers.push_back(number(key, element, expected, numbers.size() >= 3));
  return finite(key, numbers, expected);
}

std::vector<YamlMap> YamlMap::maps(const std::string& key) {
  asked_.insert(key);
  std::vector<YamlMap> result;
  const Entry* entry = find(key);
  if (entry == nullptr || entry->value.IsNull()) return result;
  if (!entry->value.IsSequence()) failAt(key, "'" + key + "' expected a list");
  for (const YAML::Node& element : entry->value) {
    if (element.IsNull()) failAt(key, "'" + key + "' has an entry without a value, expected a list of maps");
    result.emplace_back(element, file_);
  }
  return result;
}

YamlMap YamlMap::map(const std::string& key, const std::string& expected) {
  require(key, expected);
  return YamlMap(find(key)->value, file_);
}

void YamlMap::finish() const {
  for (const Entry& entry : entries_) {
    const std::string& key = entry.key.Scalar();
    if (asked_.count(key) == 0) fail(entry.key, "unknown key '" + key + "', expected one of " + known());
  }
}

void YamlMap::fail(const YAML::Node& where, const std::string& what) const {
  throw std::runtime_error(yamlPlace(file_, where.Mark().line) + oneLine(what));  // keys may have line breaks
}

std::string YamlMap::placeOf(const std::string& key) const {
  const Entry* entry = find(key);
  return yamlPlace(file_, (entry == nullptr ? node_ : entry->key).Mark().line);
}

void YamlMap::failAt(const std::string& key, const std::string& what) const {
  throw std::runtime_error(placeOf(key) + oneLine(what));
}

/// Reports that a value, or a part of it, is not of the expected kind. An empty value has no line: then the
/// line of the key is given.
void YamlMap::failIn(const std::string& key, const YAML::Node& value, const std::string& expected) const {
  const std::string what = nameOfTag(value) + "'" + key + "' cannot be read, expected " + expected;
  if (value.IsNull()) failAt(key, what);
  fail(value, what);
}

std::string YamlMap::known() const {
  std::string list;
  for (const std::string& key : asked_) list += (list.empty() ? "" : ", ") + key;
  return list;
}

double YamlMap::number(const std::string& key, const YAML::Node& value, const std::string& expected,
                       bool angle) const {
  double number = 0.0;
  if (!value.IsScalar()) failIn(key, value, expected);
  std::string text = value.Scalar(), tag = isPlainTag(value.Tag()) ? "" : value.Tag();
  if (angle && tag.empty() && text.size() > 5 && text.back() == ')') {
    // rosparam accepts deg(90) and rad(1.5), too.
    if (text.compare(0, 4, "deg(") == 0) tag = tag_degrees;
    if (text.compare(0, 4, "rad(") == 0) tag = tag_radians;
    if (!tag.empty()) text = text.substr(4, text.size() - 5);
  }
  const bool known = tag.empty() || (angle && (tag == tag_degrees || tag == tag_radians));
  if (!known || !readNumber(text, number)) failIn(key, value, expected);
  return tag == tag_degrees ? number * degree : number;
}

std::string YamlMap::text(const std::string& key, const YAML::Node& value,
                          const std::string& expected) const {
  if (!value.IsScalar() || !isPlainTag(value.Tag())) failIn(key, value, expected);
  return value.Scalar();
}

std::vector<double> YamlMap::list(const std::string& key, const YAML::Node& value,
                                  const std::string& expected) const {
  if (!value.IsSequence() || !isPlainTag(value.Tag())) failIn(key, value, expected);
  std::vector<double> numbers;
  for (const YAML::Node& element : value) numbers.push_back(number(key, element, expected));
  return numbers;
}

YamlMap loadYaml(const std::string& file, YamlReaders readers) {
  const std::string text = readText(file);
  try {
    checkYaml(text, file, readers);
    return YamlMap(YAML::Load(text), file);
  } catch (const YAML::Exception& e) {
    throw std::runtime_error(yamlPlace(file, e.mark.line) + "not YAML, " + oneLine(e.msg));
  }
}

}  // namespace tactile_clay::scene
