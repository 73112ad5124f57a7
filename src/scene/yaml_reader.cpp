#include "scene/yaml_reader.h"

#include <yaml-cpp/eventhandler.h>

#include <locale>
#include <map>
#include <sstream>

#include "scene/text_file.h"

namespace tactile_clay::scene {
namespace {

constexpr std::size_t most_nodes = 200000;  // of a file, with all that its aliases repeat
constexpr char merge_key[] = "<<";
constexpr char degrees[] = "!degrees", radians[] = "!radians";
constexpr double degree = M_PI / 180.0;  // rad

std::string at(const std::string& file, int line) {
  return file + ":" + std::to_string(line + 1) + ": ";
}

/// Tags of the core schema say what a plain value is anyway. "?" and "!" are none: plain and quoted text.
bool isPlain(const std::string& tag) {
  static const std::set<std::string> core = {"",
                                             "?",
                                             "!",
                                             "tag:yaml.org,2002:str",
                                             "tag:yaml.org,2002:float",
                                             "tag:yaml.org,2002:int",
                                             "tag:yaml.org,2002:null",
                                             "tag:yaml.org,2002:map",
                                             "tag:yaml.org,2002:seq",
                                             "tag:yaml.org,2002:bool"};
  return core.count(tag) > 0;
}

/// Looks at a file before it is built: how many documents it has, its tags, and how far aliases repeat.
class Check : public YAML::EventHandler {
 public:
  explicit Check(std::string file) : file_(std::move(file)) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(mark, "a second document begins here, expected one document a file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    count(mark, 1);
    if (anchor != 0) sizes_[anchor] = 1;
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto size = sizes_.find(anchor);
    if (size == sizes_.end()) fail(mark, "an alias of what it stands in, expected an end");
    count(mark, size->second);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string&) override {
    if (tag != degrees && tag != radians) expectPlain(mark, tag);
    count(mark, 1);
    if (anchor != 0) sizes_[anchor] = 1;
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YAML::anchor_t anchor;
    std::size_t nodes_before;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& what) const {
    throw std::runtime_error(at(file_, mark.line) + what);
  }
  void expectPlain(const YAML::Mark& mark, const std::string& tag) const {
    if (!isPlain(tag))
      fail(mark, "tag '" + tag +
                     "' is unknown, expected a value without a tag, or !degrees or !radians at an angle");
  }
  void count(const YAML::Mark& mark, std::size_t nodes) {
    nodes_ += nodes;
    if (nodes_ > most_nodes)
      fail(mark, "more than " + std::to_string(most_nodes) + " values, aliases among them, expected fewer");
  }
  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    expectPlain(mark, tag);
    open_.push_back({anchor, nodes_});
    count(mark, 1);
  }
  void close() {
    if (open_.back().anchor != 0) sizes_[open_.back().anchor] = nodes_ - open_.back().nodes_before;
    open_.pop_back();
  }

  std::string file_;
  int documents_ = 0;
  std::size_t nodes_ = 0;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, std::size_t> sizes_;  // nodes of what an anchor names, aliases repeated
};

std::string nameOfTag(const YAML::Node& node) {
  return isPlain(node.Tag()) ? "" : "tag '" + node.Tag() + "' at ";
}

/// A number as YAML writes them, in any locale. \return whether it is one
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

/// Takes the keys of a map that are not there yet.
void YamlMap::collect(const YAML::Node& map) {
  if (!map.IsMap()) fail(map, "expected a map of keys and values");
  std::set<std::string> own;
  std::vector<Entry> merges;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) fail(entry.first, "a key that is no name, expected keys and values");
    const std::string& key = entry.first.Scalar();
    if (!isPlain(entry.first.Tag())) fail(entry.first, nameOfTag(entry.first) + "a key, expected none");
    if (!own.insert(key).second) fail(entry.first, "key '" + key + "' stands there twice, expected it once");
    if (key == merge_key && entry.first.Tag() != "!")  // which is what is quoted
      merges.push_back({entry.first, entry.second});
    else if (!has(key))
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
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.key.Scalar() == key; });
  return found == entries_.end() ? nullptr : &*found;
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
  const auto list = get<std::vector<double>>(key, expected);
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
  if (!value.IsSequence() || !isPlain(value.Tag())) failIn(key, value, expected);
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
  throw std::runtime_error(at(file_, where.Mark().line) + what);
}

std::string YamlMap::placeOf(const std::string& key) const {
  const Entry* entry = find(key);
  return at(file_, (entry == nullptr ? node_ : entry->key).Mark().line);
}

void YamlMap::failAt(const std::string& key, const std::string& what) const {
  throw std::runtime_error(placeOf(key) + what);
}

/// That a value, or a part of it, is not of the kind that was expected. What has no value has no line either.
void YamlMap::failIn(const std::string& key, const YAML::Node& value, const std::string& expected) const {
  fail(value.IsNull() ? find(key)->key : value,
       nameOfTag(value) + "'" + key + "' cannot be read, expected " + expected);
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
  std::string text = value.Scalar(), tag = isPlain(value.Tag()) ? "" : value.Tag();
  if (angle && tag.empty() && text.size() > 5 && text.back() == ')') {
    // rosparam takes deg(90) and rad(1.5), too.
    if (text.compare(0, 4, "deg(") == 0) tag = degrees;
    if (text.compare(0, 4, "rad(") == 0) tag = radians;
    if (!tag.empty()) text = text.substr(4, text.size() - 5);
  }
  const bool known = tag.empty() || (angle && (tag == degrees || tag == radians));
  if (!known || !readNumber(text, number)) failIn(key, value, expected);
  return tag == degrees ? number * degree : number;
}

std::string YamlMap::text(const std::string& key, const YAML::Node& value,
                          const std::string& expected) const {
  if (!value.IsScalar() || !isPlain(value.Tag())) failIn(key, value, expected);
  return value.Scalar();
}

std::vector<double> YamlMap::list(const std::string& key, const YAML::Node& value,
                                  const std::string& expected) const {
  if (!value.IsSequence() || !isPlain(value.Tag())) failIn(key, value, expected);
  std::vector<double> numbers;
  for (const YAML::Node& element : value) numbers.push_back(number(key, element, expected));
  return numbers;
}

YamlMap loadYaml(const std::string& file) {
  const std::string text = readText(file);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Check check(file);
    while (parser.HandleNextDocument(check)) {
    }
    return YamlMap(YAML::Load(text), file);
  } catch (const YAML::Exception& e) {
    throw std::runtime_error(at(file, e.mark.line) + "not YAML, " + oneLine(e.msg));
  }
}

}  // namespace tactile_clay::scene
