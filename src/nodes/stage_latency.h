#pragma once

#include <ros/time.h>
#include <tactile_clay/RigLatency.h>

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// Topics that pass a sample of the hands on, in their order. The stage of each ends with its message.
constexpr std::size_t latency_stages_count = 7;
extern const std::array<const char*, latency_stages_count - 1> latency_topics;
/// Their stages, and last the whole way, from motion to touch.
extern const std::array<const char*, latency_stages_count> latency_stages;

/// Latency from motion to touch, stage by stage. A sample is known by its stamp. A stage lasts from where its
/// input had come to where its output has, both as one observer gets them; the first begins with the stamp.
class StageLatency {
 public:
  /// @param window s, of which samples count, by their stamps
  explicit StageLatency(double window) : window_(window) {}

  /// A message has come.
  /// @param topic its place in `latency_topics`
  void arrived(std::size_t topic, ros::Time stamp, ros::Time at);
  /// Counts also what has been answered last, of which messages may still be on their way.
  void finish();

  /// Where stamps are not of the clock by which messages come, as those of a recording, `tracking` and
  /// `motion_to_touch` have no samples.
  RigLatency message() const;

 private:
  using Arrivals = std::array<std::optional<ros::Time>, latency_stages_count - 1>;
  struct Sample {
    ros::Time stamp;
    std::array<std::optional<double>, latency_stages_count> ms;
  };

  void count(ros::Time stamp, const Arrivals& arrivals);

  double window_;
  std::map<ros::Time, Arrivals> open_;
  std::deque<Sample> samples_;
  unsigned lost_ = 0;
};

}  // namespace tactile_clay::nodes
