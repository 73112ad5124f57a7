#include "scene/yaml_check.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "scene/rosparam_number.h"
#include "scene/text_file.h"

namespace tactile_clay::scene {
namespace {

constexpr std::size_t max_nodes = 200000;  // of a file, with the nodes that its aliases repeat

class Check : public YAML::EventHandler {
 public:
  Check(std::string file, YamlReaders readers) : file_(std::move(file)), readers_(readers) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) fail(mark, "a second document begins here, expected one document per file");
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
                const std::string& text) override {
    const bool angle = tag == tag_degrees || tag == tag_radians;
    if (!angle) expectPlain(mark, tag);
    const std::string fault =
        angle || readers_ == YamlReaders::own ? "" : faultForRosparam(text, hasNoTag(tag));
    if (!fault.empty()) fail(mark, oneLine(fault));
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
    throw std::runtime_error(yamlPlace(file_, mark.line) + what);
  }
  void expectPlain(const YAML::Mark& mark, const std::string& tag) const {
    if (!isPlainTag(tag))
      fail(mark, "tag '" + tag +
                     "' is unknown, expected a value without a tag, or !degrees or !radians at an angle");
  }
  void count(const YAML::Mark& mark, std::size_t nodes) {
    nodes_ += nodes;
    if (nodes_ > max_nodes)
      fail(mark, "more than " + std::to_string(max_nodes) + " values, aliases among them, expected fewer");
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
  YamlReaders readers_;
  int documents_ = 0;
  std::size_t nodes_ = 0;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, std::size_t> sizes_;  // number of nodes of each anchor, aliases repeated
};

}  // namespace

bool isPlainTag(const std::string& tag) {
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

bool hasNoTag(const std::string& tag) {
  return tag.empty() || tag == "?";
}

std::string yamlPlace(const std::string& file, int line) {
  return file + ":" + std::to_string(line + 1) + ": ";
}

void checkYaml(const std::string& text, const std::string& file, YamlReaders readers) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Check check(file, readers);
  while (parser.HandleNextDocument(check)) {
  }
}

}  // namespace tactile_clay::scene
