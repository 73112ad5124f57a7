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

/// Topics that pass a tracker sample on, in their order. Each stage ends with the message on its topic.
constexpr std::size_t latency_stages_count = 7;
extern const std::array<const char*, latency_stages_count - 1> latency_topics;
/// Names of the stages, and last of the whole way from motion to touch.
extern const std::array<const char*, latency_stages_count> latency_stages;

/// Latency from motion to touch, stage by stage. A sample is identified by its stamp. A stage lasts from the
/// arrival of its input to the arrival of its output, both at the same observer. The first stage begins with
/// the stamp.
class StageLatency {
 public:
  /// @param window s; a sample counts if its stamp is at most that much older than the newest one
  explicit StageLatency(double window) : window_(window) {}

  /// To be called when a message has come.
  /// @param topic its place in `latency_topics`
  void arrived(std::size_t topic, ros::Time stamp, ros::Time at);
  /// Also counts the samples that were answered last, of which messages may still be on their way.
  void finish();

  /// The latencies as a message. If stamps come from another clock than times of arrival, as those of a
  /// recording, `tracking` and `motion_to_touch` have no samples.
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
