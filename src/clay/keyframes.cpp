#include "clay/keyframes.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>
#include <vector>

namespace tactile_clay::clay {
namespace {

constexpr double apart = 1.0;           // s
constexpr double time_rounding = 1e-6;  // s, of a sum of frame durations

std::size_t bytesOf(const Sculpture& s) {
  const auto of = [](const auto& values) { return values.size() * sizeof(values[0]); };
  return sizeof s + of(s.position) + of(s.velocity) + of(s.compression) + of(s.window_start) +
         of(s.material) + of(s.body) + of(s.bond_begin) + of(s.bonds) + of(s.contacts) + of(s.density_ratio) +
         of(s.sleep.lump) + of(s.sleep.mark);
}

template <typename Value>
void reserveMore(const std::vector<Value>& from, std::vector<Value>& to) {
  if (to.capacity() >= from.size()) return;
  to.clear();
  to.reserve(from.size() + from.size() / 8);
}

std::string inSeconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

}  // namespace

bool Keyframes::pass(double duration) {
  now_ += duration;
  return limits_.seconds > 0.0 && (states_.empty() || now_ - states_.back().time >= apart - time_rounding);
}

void Keyframes::keep(const Sculpture& clay, int version) {
  if (limits_.seconds <= 0.0) return;
  bytes_ += bytesOf(clay);
  State next;
  // The new state stays, whatever memory it takes: the first undo needs it.
  while (!states_.empty() && (bytes_ > limits_.bytes || isTooOld())) next = takeOldest();
  // The new state takes the memory of the oldest one. These sizes change from state to state: without room to
  // spare, most states would need other memory, and the heap would grow by the gaps between them.
  reserveMore(clay.bonds, next.clay.bonds);
  reserveMore(clay.contacts, next.clay.contacts);
  next.time = now_;
  next.version = version;
  next.clay = clay;
  states_.push_back(std::move(next));
}

const Keyframes::State& Keyframes::back(double seconds, double& went_back) {
  if (limits_.seconds <= 0.0) throw std::runtime_error("no states are kept, expected undo_seconds above 0");
  if (!(seconds >= 0.0 && std::isfinite(seconds)))
    throw std::runtime_error("seconds back: expected a number of 0 or more");
  const double target = now_ - seconds + time_rounding;
  if (states_.empty() || states_.front().time > target)
    throw std::runtime_error(inSeconds(seconds) + " back: expected at most " +
                             (states_.empty() ? "0 s, for nothing was simulated yet"
                                              : inSeconds(now_ - states_.front().time) +
                                                    ", the age of the oldest state that is kept"));
  while (states_.back().time > target) {
    bytes_ -= bytesOf(states_.back().clay);
    states_.pop_back();
  }
  went_back = now_ - states_.back().time;
  now_ = states_.back().time;
  return states_.back();
}

bool Keyframes::isTooOld() const {
  const double second = states_.size() > 1 ? states_[1].time : now_;
  return now_ - second >= limits_.seconds - time_rounding;
}

Keyframes::State Keyframes::takeOldest() {
  State oldest = std::move(states_.front());
  bytes_ -= bytesOf(oldest.clay);
  states_.pop_front();
  return oldest;
}

}  // namespace tactile_clay::clay
