#include "hand/lz_string.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace tactile_clay::hand {
namespace {

using Letter = std::uint16_t;  // a unit of UTF-16
using Letters = std::vector<Letter>;

/// Bits out of base64, six per letter, the highest first.
class Bits {
 public:
  explicit Bits(std::string base64) : text_(std::move(base64)) {}

  /// A number whose lowest bit comes first.
  std::uint32_t number(unsigned width) {
    std::uint32_t value = 0;
    for (unsigned i = 0; i < width; ++i) value |= bit() << i;
    return value;
  }

 private:
  std::uint32_t bit() {
    if (left_ == 0) {
      six_ = nextLetter();
      left_ = 6;
    }
    return six_ >> --left_ & 1U;
  }

  std::uint32_t nextLetter() {
    while (at_ < text_.size()) {
      const char c = text_[at_++];
      if (c >= 'A' && c <= 'Z') return static_cast<std::uint32_t>(c - 'A');
      if (c >= 'a' && c <= 'z') return static_cast<std::uint32_t>(c - 'a' + 26);
      if (c >= '0' && c <= '9') return static_cast<std::uint32_t>(c - '0' + 52);
      if (c == '+') return 62;
      if (c == '/') return 63;
      if (c == '=') return 0;  // fills up the last letters
      if (c != ' ' && c != '\t' && c != '\r' && c != '\n') throw std::runtime_error("is not base64");
    }
    throw std::runtime_error("is cut off");
  }

  std::string text_;
  std::size_t at_ = 0;
  std::uint32_t six_ = 0;
  unsigned left_ = 0;
};

/// Words by their codes. Each is an earlier word and one letter. The first three codes mean something else.
class Dictionary {
 public:
  std::uint32_t size() const { return static_cast<std::uint32_t>(words_.size()); }
  void add(std::uint32_t before, Letter last) { words_.push_back({before, last}); }

  Letters word(std::uint32_t code) const {
    Letters letters;
    for (; code != none; code = words_[code].before) letters.push_back(words_[code].last);
    std::reverse(letters.begin(), letters.end());
    return letters;
  }

  static constexpr std::uint32_t none = 0;

 private:
  struct Word {
    std::uint32_t before;
    Letter last;
  };
  std::vector<Word> words_{3};
};

/// Makes UTF-8 of units of UTF-16, which come one after the other. Each unit becomes one byte at least, so
/// the maximum of bytes limits the units as well: a half of a letter that stands alone becomes U+FFFD.
class Utf8 {
 public:
  explicit Utf8(std::size_t max_bytes) : maximum_(max_bytes) {}

  void add(const Letters& letters) {
    for (const Letter letter : letters) add(letter);
    requireWithin();
  }

  std::string take() {
    endHalf();
    requireWithin();
    return std::move(text_);
  }

 private:
  static constexpr std::uint32_t replacement = 0xFFFD;

  void requireWithin() const {
    if (text_.size() > maximum_)
      throw std::runtime_error("unpacks to more than " + std::to_string(maximum_) +
                               " bytes, expected at most as many");
  }

  void add(std::uint32_t unit) {
    const bool low = unit >= 0xDC00 && unit < 0xE000;
    if (low && high_ != 0) {
      write(0x10000 + ((high_ - 0xD800) << 10U) + (unit - 0xDC00));
      high_ = 0;
      return;
    }
    endHalf();
    if (unit >= 0xD800 && unit < 0xDC00)
      high_ = unit;  // the other half follows
    else
      write(low ? replacement : unit);
  }

  /// Writes the first half of a letter, if there is one whose other half does not follow.
  void endHalf() {
    if (high_ != 0) write(replacement);
    high_ = 0;
  }

  void write(std::uint32_t letter) {
    const auto byte = [this](std::uint32_t value) {
      text_ += static_cast<char>(static_cast<unsigned char>(value));
    };
    if (letter < 0x80) return byte(letter);
    const int more = letter < 0x800 ? 1 : letter < 0x10000 ? 2 : 3;
    constexpr std::array<std::uint32_t, 4> mark = {0, 0xC0, 0xE0, 0xF0};
    byte(mark[static_cast<std::size_t>(more)] | letter >> (6U * static_cast<unsigned>(more)));
    for (int k = more - 1; k >= 0; --k) byte(0x80U | (letter >> (6U * static_cast<unsigned>(k)) & 0x3FU));
  }

  std::size_t maximum_;
  std::string text_;
  std::uint32_t high_ = 0;  // first half of a letter, 0: none
};

}  // namespace

std::string unpackLzString(const std::string& base64, std::size_t max_bytes) {
  enum : std::uint32_t { short_letter, long_letter, end };
  Bits bits(base64);
  Dictionary dictionary;
  Utf8 text(max_bytes);
  unsigned width = 2;
  std::uint32_t room = 2;  // words until codes become one bit longer
  Letters last;
  std::uint32_t last_code = Dictionary::none;
  const auto grow = [&] {
    if (--room == 0) room = 1U << width++;
  };
  while (true) {
    std::uint32_t code = bits.number(width);
    if (code == end) return text.take();
    if (code == short_letter || code == long_letter) {
      dictionary.add(Dictionary::none, static_cast<Letter>(bits.number(code == short_letter ? 8 : 16)));
      code = dictionary.size() - 1;
      grow();
    }
    // A code may be that of the word it adds: the last word and its first letter.
    const bool own = code == dictionary.size() && !last.empty();
    if (code >= dictionary.size() && !own) throw std::runtime_error("has a word that nobody knows");
    Letters word = own ? last : dictionary.word(code);
    if (own) word.push_back(last.front());
    text.add(word);
    if (!last.empty()) dictionary.add(last_code, word.front());
    grow();
    last = std::move(word);
    last_code = code;
  }
}

}  // namespace tactile_clay::hand
