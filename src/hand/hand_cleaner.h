#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "hand/one_euro.h"
#include "hand/tracked_hand.h"
#include "safety/silence_times.h"

namespace tactile_clay::hand {

constexpr double max_prediction = 0.02;  // s; with more, hands overshoot where they turn

struct CleanConfig {
  OneEuroConfig position{2.0, 100.0, 1.0};    // beta in 1/m
  OneEuroConfig orientation{2.0, 10.0, 1.0};  // beta in 1/rad
  /// s; a hand that is not seen stays as it was for `hold`, and has faded out after `gone`
  double hold = silence_times::seconds(silence_times::hand_held);
  double gone = silence_times::seconds(silence_times::hand_gone);
  double same_hand_time = 0.1;       // s after it was last seen, within which it is still the same hand
  double same_hand_distance = 0.05;  // m, of the palm, within which a new id is the same hand
  double blend = 0.1;                // s, over which the step of a changed id is blended
  double artefact_speed = 1.5;       // m/s; an artefact's speed differs by more from its motion
  double artefact_confidence = 0.5;  // an artefact has less
  double prediction = 0.0;           // s ahead, 0 to max_prediction
};

/// @throws std::invalid_argument with one line if a number is out of its range
void validate(const CleanConfig& config);

/// Numbers of events since the start.
struct CleanCounts {
  std::uint64_t dropouts = 0;      // samples without a hand that was there before, which was held or faded
  std::uint64_t losses = 0;        // hands that had faded out
  std::uint64_t id_changes = 0;    // changes of the id of the same hand
  std::uint64_t side_changes = 0;  // changes of the side of an id that stayed in its place
  std::uint64_t artefacts = 0;     // samples left out
  std::uint64_t jumps = 0;         // steps that no hand makes (palmJumps), or far steps under a new id
  std::uint64_t doubles = 0;       // hands left out beside another one of the same side
};

/// Turns the hands of a tracker into hands that the clay can feel. State is kept by side, not by id:
///
/// - Poses pass a One-Euro filter. It starts anew when a hand returns.
/// - A hand that is not seen is held for `hold`, and fades out until `gone`. It grows thin about its bones,
///   to half its radii, so that skin and touch withdraw from the clay. Its confidence falls to zero.
/// - A hand that was held or left out catches up with the tracked hand. Its palm moves at most 1.15 times as
///   fast as the tracked palm has ever moved, so it never leaps if the tracked hand did not.
/// - A new id is the same hand if that was seen less than `same_hand_time` ago and is within
///   `same_hand_distance` of its place. The step that this makes is blended over `blend`.
/// - A new id farther away, or a jump that no hand makes, is another hand. It is there from its second
///   sample.
/// - If an id changes its side but stays in its place, the hand of the old side ends at once.
/// - If there are several hands of one side (the tracker may take the other hand for it), the one that was
///   there before counts: the one with its id, or else the nearest. If there was none, the most confident one
///   counts.
/// - A step of an unsure hand that its motion does not explain is an artefact. It is left out as if the hand
///   was not seen. A stroke is no artefact, however fast: its speed agrees with the motion before or after.
/// - A missing joint is missing at once. Its filter starts anew when it is back.
class HandCleaner {
 public:
  /// @throws std::invalid_argument as validate
  explicit HandCleaner(const CleanConfig& config);

  /// Replaces the settings; hands go on as they are.
  /// @throws std::invalid_argument as validate, and keeps them
  void configure(const CleanConfig& config);

  /// Cleans the hands of a frame in place. At most one hand per side is left, the left one first. The hands
  /// have passed hand_check; stamps increase.
  void clean(TrackedFrame& frame);
  /// Sets the hands at the stamp of `frame`, for which the tracker has sent nothing. While the tracker's next
  /// frame is not due (with a slow one, up to 0.07 s), the hands are held.
  void hold(TrackedFrame& frame);

  /// True while there are hands, seen or not.
  bool present() const {
    return (tracks_[0] && tracks_[0]->presence > 0.0) || (tracks_[1] && tracks_[1]->presence > 0.0);
  }
  const CleanCounts& counts() const { return counts_; }

 private:
  struct Step {  // of a joint, from its expected to its seen pose
    Eigen::Vector3d position;
    Eigen::Vector3d rotation;  // rotation vector, rad
  };
  struct Motion {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
    Eigen::Vector3d turning = Eigen::Vector3d::Zero();   // rad/s, in the joint's frame
  };
  struct LeftOut {
    Eigen::Vector3d palm;  // m
    std::chrono::nanoseconds stamp;
  };
  struct Track {
    TrackedHand seen;                  // as the tracker sent it
    TrackedHand blended;               // `seen`, without what is left of the step of a changed id
    TrackedHand clean;                 // `blended`, filtered
    TrackedHand released;              // `clean`, predicted
    std::chrono::nanoseconds stamp;    // when it was seen
    std::chrono::nanoseconds updated;  // when it was seen or missed
    double presence = 1.0;             // 0-1
    bool shown = true;                 // false: it jumped to its place, and was seen there only once
    /// m/s, of the palm, between the last two that were seen
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    double fastest = 0.0;             // m/s, maximum speed of the palm since the track began
    std::optional<LeftOut> left_out;  // the last artefact since `stamp`
    std::array<OneEuro<3>, joint_count> position;
    std::array<OneEuroRotation, joint_count> orientation;
    std::array<Motion, joint_count> motion;
    std::optional<std::array<Step, joint_count>> steps;  // steps of a changed id, at blend_start
    std::chrono::nanoseconds blend_start{0};
  };

  void update(TrackedFrame& frame);
  const TrackedHand* choose(const TrackedFrame& frame, Side side);
  void see(std::optional<Track>& track, const TrackedHand& hand, std::chrono::nanoseconds stamp);
  bool isArtefact(const Track& track, const TrackedHand& hand, std::chrono::nanoseconds stamp) const;
  void goOn(Track& track, const TrackedHand& hand, std::chrono::nanoseconds stamp);
  void filter(Track& track, const TrackedHand& hand, std::chrono::nanoseconds stamp);
  void miss(std::optional<Track>& track, std::chrono::nanoseconds stamp);
  void forget(std::optional<Track>& track, std::chrono::nanoseconds stamp);
  void startBlend(Track& track, const TrackedHand& hand, std::chrono::nanoseconds stamp);

  CleanConfig config_;
  double period_ = 0.0;  // s, between the tracker's frames
  std::optional<std::chrono::nanoseconds> last_frame_;
  std::array<std::optional<Track>, 2> tracks_;  // by side
  CleanCounts counts_;
};

}  // namespace tactile_clay::hand
