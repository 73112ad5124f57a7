#pragma once

#include <array>
#include <chrono>
#include <optional>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Keeps a hand from leaping where the tracked hand did not: no joint that is shown is faster than 1.15 times
/// what the tracker has shown of this joint. One per side.
///
/// - A hand that was shown in the frame before moves toward its goal as a whole, by the share of its step for
///   which no joint is too fast.
/// - A joint that was not shown in the frame before is shown if it could have come there at that speed since
/// it
///   was last shown. If it could not, its finger is missing; without palm, wrist or three fingers there is no
///   hand.
class SpeedLimit {
 public:
  using Time = std::chrono::nanoseconds;

  /// To be called for each frame.
  /// @param seen the hand as the tracker sent it in this frame; null if it was not seen
  /// @param goal the hand that is to be shown; null if there is none
  /// @return the hand that may be shown
  std::optional<TrackedHand> step(const TrackedHand* seen, const TrackedHand* goal, Time stamp);

  /// To be called if the next hand is another one, which may be anywhere.
  void forget() { joints_ = {}; }

 private:
  struct Sample {
    JointPose pose;
    Time stamp;
  };
  struct Joint {
    std::optional<Sample> seen, shown;  // the last ones
    double fastest = 0.0;               // m/s, of what was seen
  };

  void see(const TrackedHand& hand, Time stamp);
  bool wasShown(int joint) const { return joints_[joint].shown && joints_[joint].shown->stamp == last_; }
  double share(const TrackedHand& goal, Time stamp) const;
  bool couldCome(int joint, const JointPose& pose, Time stamp) const;
  void approach(TrackedHand& hand, Time stamp) const;
  bool leaveOut(TrackedHand& hand, bool seen, Time stamp) const;

  std::array<Joint, joint_count> joints_;
  std::optional<Time> last_;  // of the frame before
};

}  // namespace tactile_clay::hand
