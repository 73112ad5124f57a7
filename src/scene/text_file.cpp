#include "scene/text_file.h"

#include <algorithm>
#include <boost/locale/utf.hpp>
#include <cctype>
#include <stdexcept>

#include "files/input_file.h"

namespace tactile_clay::scene {
namespace {

using Utf8 = boost::locale::utf::utf_traits<char>;

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

/// Whether a text may contain a character: no control characters except tabs and line ends.
bool isText(boost::locale::utf::code_point c) {
  return boost::locale::utf::is_valid_codepoint(c) && (c >= 0x20 || c == '\t' || c == '\n' || c == '\r') &&
         c != 0x7f;
}

}  // namespace

void expectUtf8(std::string& text, const std::string& path) {
  if (startsWith(text, "\xff\xfe") || startsWith(text, "\xfe\xff"))
    throw std::runtime_error(path + ": is UTF-16, expected a text in UTF-8");
  if (startsWith(text, "\xef\xbb\xbf")) text.erase(0, 3);
  for (auto at = text.cbegin(); at != text.cend();) {
    const auto from = at;
    const auto c = Utf8::decode(at, text.cend());
    if (isText(c)) continue;
    const auto line = 1 + std::count(text.cbegin(), from, '\n');
    const bool control = boost::locale::utf::is_valid_codepoint(c);
    throw std::runtime_error(
        path + ":" + std::to_string(line) +
        (control ? ": a control character (byte " + std::to_string(c) + "), expected a text in UTF-8"
                 : ": bytes that are no UTF-8, expected a text in UTF-8; is it Latin-1?"));
  }
}

std::string readText(const std::string& path) {
  std::string text = files::readWhole(path, files::maximum::text);
  expectUtf8(text, path);
  return text;
}

std::string oneLine(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const bool blank = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace tactile_clay::scene
