#include "scene/xml_encoding.h"

#include <iconv.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <regex>
#include <stdexcept>

#include "scene/text_file.h"

namespace tactile_clay::scene {
namespace {

constexpr std::size_t declared_within = 200;  // bytes: a declaration is at the start

struct Converter {
  Converter(const std::string& from, const std::string& file) : handle(iconv_open("UTF-8", from.c_str())) {
    if (handle == reinterpret_cast<iconv_t>(-1))
      throw std::runtime_error(file + ": encoding '" + from +
                               "' is unknown, expected UTF-8 or another known one");
  }
  ~Converter() { iconv_close(handle); }
  Converter(const Converter&) = delete;
  Converter& operator=(const Converter&) = delete;

  iconv_t handle;
};

std::string inUtf8(std::string bytes, const std::string& encoding, const std::string& file) {
  const Converter converter(encoding, file);
  std::string text(4 * bytes.size() + 4, '\0');  // no character needs more bytes than four
  char *from = &bytes[0], *to = &text[0];
  std::size_t left = bytes.size(), room = text.size();
  if (iconv(converter.handle, &from, &left, &to, &room) == static_cast<std::size_t>(-1)) {
    const auto line = 1 + std::count(&bytes[0], from, '\n');
    throw std::runtime_error(file + ":" + std::to_string(line) + ": bytes that are no " + encoding +
                             ", which the file declares");
  }
  text.resize(text.size() - room);
  return text;
}

}  // namespace

std::string decodedXml(std::string bytes, const std::string& file) {
  const bool wide = bytes.compare(0, 2, "\xff\xfe") == 0 || bytes.compare(0, 2, "\xfe\xff") == 0;
  if (wide) bytes = inUtf8(std::move(bytes), "UTF-16", file);
  static const std::regex declaration(R"(^(\s*<\?xml[^>]*?encoding\s*=\s*["'])([A-Za-z0-9._:-]+)(["']))");
  std::smatch found;
  const std::string start = bytes.substr(0, declared_within);
  if (std::regex_search(start, found, declaration)) {
    const std::string encoding = found[2];
    const auto at = static_cast<std::size_t>(found.position(2));
    std::string lower = encoding;
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (lower != "utf-8" && lower != "utf8") {
      bytes.replace(at, encoding.size(), "UTF-8");
      if (!wide) bytes = inUtf8(std::move(bytes), encoding, file);
    }
  }
  expectUtf8(bytes, file);
  return bytes;
}

}  // namespace tactile_clay::scene
