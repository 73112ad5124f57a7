#include "nodes/stage_latency.h"

#include <algorithm>
#include <cmath>

#include "nodes/stamps.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr double longest = 10.0;       // s; a greater age comes from another clock
constexpr std::size_t max_open = 600;  // samples without an answer: ten seconds of them
constexpr float bin_ms = 1.0f;
constexpr std::size_t bins = 64;

/// The smallest of ascending numbers that at least this share of them does not exceed.
float quantile(const std::vector<float>& ascending, double share) {
  const double rank = std::ceil(share * static_cast<double>(ascending.size()));
  return ascending[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
}

}  // namespace

const std::array<const char*, latency_stages_count - 1> latency_topics = {
    topic::hands_tracked,  topic::hands_skin,   topic::clay_contacts,
    topic::hands_pressure, topic::focal_points, topic::array_state};
const std::array<const char*, latency_stages_count> latency_stages = {
    "tracking", "hand", "clay", "pressure", "renderer", "array", "motion_to_touch"};

void StageLatency::arrived(std::size_t topic, ros::Time stamp, ros::Time at) {
  // Belongs to no sample, such as the state of an array that waits for its first one.
  if (stamp.isZero()) return;
  if (!samples_.empty() && secondsBetween(stamp, samples_.back().stamp) > longest)
    samples_.clear();                                                                          // another run
  if (!samples_.empty() && stamp <= samples_.back().stamp && open_.count(stamp) == 0) return;  // repeated
  std::optional<ros::Time>& arrival = open_[stamp].at(topic);
  if (!arrival) arrival = at;
  if (topic + 1 < latency_topics.size()) {
    if (open_.size() > max_open) open_.clear();  // nobody answers
    return;
  }
  // Samples before the answered one have been answered, too, or never will be.
  while (!open_.empty() && open_.begin()->first < stamp) {
    count(open_.begin()->first, open_.begin()->second);
    open_.erase(open_.begin());
  }
}

void StageLatency::finish() {
  for (const auto& [stamp, arrivals] : open_)
    if (arrivals.back()) count(stamp, arrivals);
  open_.clear();
}

void StageLatency::count(ros::Time stamp, const Arrivals& arrivals) {
  if (!arrivals.back()) {
    ++lost_;
    return;
  }
  Sample sample{stamp, {}};
  const double age = secondsBetween(stamp, *arrivals.back());
  const bool one_clock = age >= 0.0 && age < longest;
  std::optional<ros::Time> before;
  if (one_clock) before = stamp;
  for (std::size_t k = 0; k < arrivals.size(); ++k) {
    if (!arrivals[k]) continue;  // as in a bag without the topic: its time counts for the next stage
    if (before) sample.ms[k] = 1e3 * secondsBetween(*before, *arrivals[k]);
    before = arrivals[k];
  }
  if (one_clock) sample.ms.back() = 1e3 * age;
  samples_.push_back(sample);
  while (secondsBetween(samples_.front().stamp, stamp) > window_) samples_.pop_front();
}

RigLatency StageLatency::message() const {
  RigLatency out;
  out.window = static_cast<float>(window_);
  out.bin_ms = bin_ms;
  out.bins = bins;
  out.lost = lost_;
  if (!samples_.empty()) out.header.stamp = samples_.back().stamp;
  for (std::size_t k = 0; k < latency_stages.size(); ++k) {
    std::vector<float> ms;
    std::vector<std::uint32_t> counts(bins, 0);
    for (const Sample& sample : samples_) {
      if (!sample.ms[k]) continue;
      ms.push_back(static_cast<float>(*sample.ms[k]));
      const float bin = std::clamp(ms.back() / bin_ms, 0.0f, static_cast<float>(bins - 1));
      ++counts[static_cast<std::size_t>(bin)];
    }
    std::sort(ms.begin(), ms.end());
    out.stages.push_back(latency_stages[k]);
    out.samples.push_back(static_cast<std::uint32_t>(ms.size()));
    out.p50_ms.push_back(ms.empty() ? NAN : quantile(ms, 0.5));
    out.p99_ms.push_back(ms.empty() ? NAN : quantile(ms, 0.99));
    out.longest_ms.push_back(ms.empty() ? NAN : ms.back());
    out.counts.insert(out.counts.end(), counts.begin(), counts.end());
  }
  return out;
}

}  // namespace tactile_clay::nodes
