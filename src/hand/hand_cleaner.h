#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "hand/clean_config.h"
#include "hand/hand_track.h"
#include "hand/speed_limit.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

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
/// - A hand never leaps if the tracked hand did not (SpeedLimit). So a hand that was held or left out catches
///   up with the tracked hand. A hand or finger that was gone is there again as soon as it could have come
///   there.
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
  void update(TrackedFrame& frame);
  const TrackedHand* choose(const TrackedFrame& frame, Side side);
  void see(std::optional<HandTrack>& track, const TrackedHand& hand, std::chrono::nanoseconds stamp);
  void miss(std::optional<HandTrack>& track, std::chrono::nanoseconds stamp);
  void forget(std::optional<HandTrack>& track, std::chrono::nanoseconds stamp);

  CleanConfig config_;
  double period_ = 0.0;                                 // s, between the tracker's frames
  std::optional<std::chrono::nanoseconds> last_frame_;  // of the tracker
  std::array<std::optional<HandTrack>, 2> tracks_;      // by side
  std::array<SpeedLimit, 2> limits_;                    // by side
  CleanCounts counts_;
};

}  // namespace tactile_clay::hand
