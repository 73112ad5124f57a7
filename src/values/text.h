#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace tactile_clay::values {

/// A number as text with six significant digits. Its decimal point is a point in every locale.
inline std::string text(double value) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.begin(), buffer.end(), value, std::chars_format::general, 6).ptr;
  return {buffer.begin(), end};
}

/// The numbers of a text, with white space between them. Their decimal point is a point in every locale.
/// @return nothing if the text has something else in it, or a number that is not finite
inline std::optional<std::vector<double>> numbersOf(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::vector<double> numbers;
  while (!(stream >> std::ws).eof()) {
    double number = 0.0;
    if (!(stream >> number) || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

/// Maximum length of a line that may come again and again, in bytes, and that of the last line of a program.
constexpr std::size_t longest_line = 400, longest_last_line = 4000;

/// A text from outside as one line of printable characters. A terminal obeys control characters: those below
/// a blank, DEL, and the second set of them (U+0080 to U+009F). Each of their bytes becomes '?'.
/// @param longest maximum length in bytes; what is longer is cut, and ends with "..."
inline std::string printableLine(std::string text, std::size_t longest = longest_line) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const bool cut = text.size() > longest;
  if (cut) {
    while (longest > 0 && (byte(longest) & 0xC0U) == 0x80U) --longest;  // not within a letter of UTF-8
    text.resize(longest);
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool second_set = byte(i) == 0xC2 && i + 1 < text.size() && byte(i + 1) < 0xA0;
    if (second_set) text[i + 1] = '?';
    if (second_set || byte(i) < 0x20 || byte(i) == 0x7F) text[i] = '?';
  }
  return cut ? text + "..." : text;
}

}  // namespace tactile_clay::values
