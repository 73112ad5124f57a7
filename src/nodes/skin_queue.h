#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <vector>

namespace tactile_clay::nodes {

/// Skins on their way from the subscriber's thread to the clay's. In lockstep each is one frame; live those
/// that came since the frame before make one together.
class SkinQueue {
 public:
  using Cloud = sensor_msgs::PointCloud2::ConstPtr;
  using Clock = std::chrono::steady_clock;

  explicit SkinQueue(bool lockstep) : lockstep_(lockstep) {}

  /// Live, the oldest of many leaves.
  /// @throws std::runtime_error where too many wait (requireRoom)
  void push(const Cloud& skin);
  /// Ends all waiting, for good.
  void stop();

  /// Waits for a skin, to `until` at most; in lockstep as long as it takes.
  /// @param[out] skins those that wait, the oldest first; in lockstep one
  /// @return false where the queue was stopped
  bool wait(Clock::time_point until, std::vector<Cloud>& skins);

  /// How many were overtaken by newer ones.
  unsigned overtaken() const;

 private:
  static constexpr std::size_t max_live = 64;  // that wait: a second of hands, which no frame takes

  const bool lockstep_;
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  std::deque<Cloud> skins_;
  bool stopped_ = false;
  unsigned overtaken_ = 0;
};

}  // namespace tactile_clay::nodes
