#include "device/stamp_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "safety/silence_times.h"

namespace tactile_clay::device {
namespace {

constexpr double other_clock = silence_times::seconds(silence_times::other_clock);

/// s; a clock that somebody has set is not that wrong, and recordings are seldom played so soon.
constexpr double recorded_before = 3600.0;

/// Number of late stamps in a row, half a second at 60 Hz: too many for a short delay.
constexpr unsigned steadily = 30;

std::string apart(double behind, const char* also) {
  char words[160];
  std::snprintf(words, sizeof words,
                "their stamps are %.2f s %s this computer's clock: %scompare the hosts' clocks",
                std::abs(behind), behind < 0.0 ? "ahead of" : "behind", also);
  return words;
}

}  // namespace

StampCheck::Age StampCheck::operator()(double behind, bool played) {
  if (mode_ == Mode::off) return {};
  const double far = std::abs(behind);
  recording_ = false;
  if (far <= other_clock) {
    live_ = true;
  } else if (mode_ == Mode::found && (played || (!live_ && far > recorded_before))) {
    recording_ = true;
    late_ = 0;
    return {};
  }
  const bool late = !(far <= timeout_);
  nearest_ = late_ == 0 ? behind : std::abs(behind) < std::abs(nearest_) ? behind : nearest_;
  late_ = late ? late_ + 1 : 0;
  if (far > other_clock || (late && behind < 0.0)) return {behind, apart(behind, "")};
  if (late_ >= steadily) return {behind, apart(nearest_, "what sends them is slow, or ")};
  return {behind, ""};
}

void StampCheck::restart() {
  live_ = recording_ = false;
  late_ = 0;
}

}  // namespace tactile_clay::device
