#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <vector>

namespace tactile_clay::nodes {

/// Skins on their way from the subscriber's thread to the clay's. In lockstep each skin makes one frame.
/// Live, all skins since the last frame make one frame together.
class SkinQueue {
 public:
  using Cloud = sensor_msgs::PointCloud2::ConstPtr;
  using Clock = std::chrono::steady_clock;

  explicit SkinQueue(bool lockstep) : lockstep_(lockstep) {}

  /// Live, if 64 skins wait, the oldest is removed.
  /// @throws std::runtime_error if too many wait (requireRoom)
  void push(const Cloud& skin);
  /// Ends all waiting, for good.
  void stop();

  /// Waits for a skin until `until` at most; in lockstep without limit.
  /// @param[out] skins those that wait, the oldest first; in lockstep one
  /// @return false if the queue was stopped
  bool wait(Clock::time_point until, std::vector<Cloud>& skins);

  /// Number of skins that were overtaken by newer ones.
  unsigned overtaken() const;

 private:
  // Maximum number of skins that wait: about a second of hands. No frame takes so long.
  static constexpr std::size_t max_live = 64;

  const bool lockstep_;
  mutable std::mutex mutex_;  // protects all members below
  std::condition_variable came_;
  std::deque<Cloud> skins_;
  bool stopped_ = false;
  unsigned overtaken_ = 0;
};

}  // namespace tactile_clay::nodes
