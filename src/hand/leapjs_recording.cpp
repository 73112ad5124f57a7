#include "hand/leapjs_recording.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include "hand/leap_json.h"
#include "hand/lz_string.h"

namespace tactile_clay::hand {
namespace {

using leap::Json;

constexpr char blank[] = " \t\r\n";
constexpr std::size_t max_frames = 1'000'000;  // two hours and a half of 110 frames per second

/// Structure of a JSON text, found by its brackets alone.
struct Contents {
  std::vector<std::string> keys;                           // of the outermost object, in their order
  std::vector<std::pair<std::size_t, std::size_t>> items;  // of its array "frames", or of the outermost array
  bool closed = false;                                     // whether the outermost bracket is closed

  bool tooMany() const { return keys.size() > max_frames || items.size() > max_frames; }
};

/// Index after the string that begins at `i`.
std::size_t afterString(const std::string& text, std::size_t i) {
  for (++i; i < text.size() && text[i] != '"'; ++i)
    if (text[i] == '\\') ++i;
  return i + 1;
}

Contents contentsOf(const std::string& text) {
  Contents contents;
  std::size_t i = text.find_first_not_of(blank);
  if (i == std::string::npos || (text[i] != '{' && text[i] != '[')) return contents;
  std::size_t depth = 0, item = 0;
  // Depth of the items; 0 outside of their array.
  std::size_t inside = text[i] == '[' ? 1 : 0;
  for (; i < text.size() && !contents.closed && !contents.tooMany(); ++i) {
    const char c = text[i];
    if (c == '"') {
      const std::size_t end = afterString(text, i);
      const std::size_t next = std::min(text.find_first_not_of(blank, end), text.size());
      if (depth == 1 && next < text.size() && text[next] == ':' && inside == 0) {
        contents.keys.push_back(text.substr(i + 1, end - i - 2));
        const std::size_t value = std::min(text.find_first_not_of(blank, next + 1), text.size());
        if (contents.keys.back() == "frames" && value < text.size() && text[value] == '[') inside = 2;
      }
      i = end - 1;
    } else if (c == '{' || c == '[') {
      if (inside > 0 && depth == inside) item = i;
      ++depth;
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
      if (inside > 0 && depth == inside) contents.items.emplace_back(item, i + 1 - item);
      if (inside > 0 && depth < inside) inside = 0;
      contents.closed = depth == 0;
    }
  }
  return contents;
}

/// Whether the first JSON value of the text has one of the keys that only a recording has.
bool holdsFrames(const std::string& begin) {
  const Contents contents = contentsOf(begin);
  return std::any_of(contents.keys.begin(), contents.keys.end(),
                     [](const std::string& key) { return key == "frames" || key == "metadata"; });
}

bool isBase64(const std::string& text) {
  constexpr std::size_t shortest = 32;  // a shorter text may be a word
  constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=\r\n";
  return text.size() >= shortest && text.find_first_not_of(letters) == std::string::npos;
}

/// Unpacks one frame. The frame and the names are within leap::Limits, but each object of a list repeats its
/// names, so the bytes of all names that are written have a limit, too.
class Unpacker {
 public:
  /// Makes an object of values in the order of `names`. A name is a text, {"list": [names]} for a list of
  /// such objects, or {"object": names} for one.
  Json operator()(const Json& names,
                  const Json& values) {  // NOLINT(misc-no-recursion): as deep as the names, which are checked
    if (!names.is_array() || !values.is_array() || values.size() > names.size())
      throw std::runtime_error("has " + std::to_string(values.size()) + " values, expected one for each of " +
                               std::to_string(names.size()) + " names");
    Json object = Json::object();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Json& name = names[i];
      const bool missing = values[i].is_null();  // missing in the frame that was packed
      if (name.is_string()) {
        if (!missing) object[written(name.get_ref<const std::string&>())] = values[i];
        continue;
      }
      if (!name.is_object() || name.size() != 1 || !name.begin()->is_array() || name.begin()->empty())
        throw std::runtime_error("has names that are none, expected those of leapjs-playback's format 2");
      const Json& inner = *name.begin();
      if (!inner[0].is_array()) {
        if (!missing) object[written(name.begin().key())] = (*this)(inner, values[i]);
        continue;
      }
      Json& list = object[written(name.begin().key())] = Json::array();
      for (const Json& value : values[i]) list.push_back((*this)(inner[0], value));
    }
    return object;
  }

 private:
  /// @throws std::runtime_error if this name is one too many
  const std::string& written(const std::string& name) {
    bytes_ += name.size();
    if (bytes_ > maximum_)
      throw std::runtime_error("unpacks to names of more than " + std::to_string(maximum_) +
                               " bytes, expected at most as many");
    return name;
  }

  static constexpr std::size_t maximum_ = leap::Limits().bytes;
  std::size_t bytes_ = 0;  // of the names that are written
};

}  // namespace

bool LeapjsRecording::isOne(const std::string& begin) {
  const std::size_t first = begin.find_first_not_of(blank);
  if (first == std::string::npos) return false;
  return begin[first] == '[' || (begin[first] == '{' ? holdsFrames(begin) : isBase64(begin));
}

LeapjsRecording::LeapjsRecording(std::string text, std::size_t max_bytes) : text_(std::move(text)) {
  const std::size_t first = text_.find_first_not_of(blank);
  if (first != std::string::npos && text_[first] != '{' && text_[first] != '[') {
    try {
      text_ = unpackLzString(text_, max_bytes);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(std::string("as LZ-string of leapjs-playback ") + error.what());
    }
  }
  if (text_.size() > max_bytes)
    throw std::runtime_error("has " + std::to_string(text_.size()) + " bytes, expected at most " +
                             std::to_string(max_bytes));
  const std::size_t begin = text_.find_first_not_of(blank);
  if (begin == std::string::npos || (text_[begin] != '{' && text_[begin] != '['))
    throw std::runtime_error("unpacks to no JSON, as LZ-string of leapjs-playback would");
  Contents contents = contentsOf(text_);
  if (contents.tooMany())
    throw std::runtime_error("has more than " + std::to_string(max_frames) + " frames, expected fewer");
  if (!contents.closed) throw std::runtime_error("ends within its JSON");
  frames_ = std::move(contents.items);
  if (frames_.empty()) throw std::runtime_error("has no frames, as a recording of leapjs-playback would");
  if (text_[frames_.front().first] != '[') return;
  names_ = at(frames_.front());
  leap::parse(names_);
  frames_.erase(frames_.begin());
}

std::string LeapjsRecording::frame(std::size_t index) const {
  if (names_.empty()) return at(frames_[index]);
  return Unpacker()(leap::parse(names_), leap::parse(at(frames_[index])))
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tactile_clay::hand
