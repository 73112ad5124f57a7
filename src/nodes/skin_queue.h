#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>

namespace tactile_clay::nodes {

/// Skins on their way from the subscriber's thread to the clay's. In lockstep each is one frame; live the
/// newest one wins.
class SkinQueue {
 public:
  using Skin = sensor_msgs::PointCloud2::ConstPtr;
  using Clock = std::chrono::steady_clock;

  explicit SkinQueue(bool lockstep) : lockstep_(lockstep) {}

  /// \throws std::runtime_error where too many wait (requireRoom)
  void push(const Skin& skin);
  /// Ends all waiting, for good.
  void stop();

  /// Waits for a skin, to `until` at most; in lockstep as long as it takes. \param[out] skin the oldest that
  /// waits, or null \return false where the queue was stopped
  bool wait(Clock::time_point until, Skin& skin);

  /// How many were overtaken by newer ones.
  unsigned overtaken() const;

 private:
  const bool lockstep_;
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  std::deque<Skin> skins_;
  bool stopped_ = false;
  unsigned overtaken_ = 0;
};

}  // namespace tactile_clay::nodes
