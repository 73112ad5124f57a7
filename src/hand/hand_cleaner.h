#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "hand/one_euro.h"
#include "hand/tracked_hand.h"
#include "safety/silence_times.h"

namespace tactile_clay::hand {

constexpr double max_prediction = 0.02;  // s; farther ahead hands overshoot where they turn

struct CleanConfig {
  OneEuroConfig position{2.0, 100.0, 1.0};    // beta per m
  OneEuroConfig orientation{2.0, 10.0, 1.0};  // beta per rad
  /// s, that a hand which is not seen stays as it was, and after which it has faded out
  double hold = silence_times::seconds(silence_times::hand_held);
  double gone = silence_times::seconds(silence_times::hand_gone);
  double same_hand_time = 0.1;       // s after it was last seen, it is still the same hand
  double same_hand_distance = 0.05;  // m, of the palm, within which another id is the same hand
  double blend = 0.1;                // s, over which the step of a changed id is taken
  double artefact_speed = 1.5;       // m/s that the palm is off its motion, with a confidence below
  double artefact_confidence = 0.5;
  double prediction = 0.0;  // s ahead, 0 to max_prediction
};

/// @throws std::invalid_argument with one line where a number is out of its range
void validate(const CleanConfig& config);

/// How often, since the start.
struct CleanCounts {
  std::uint64_t dropouts = 0;      // samples without a hand that was there before, which was held or faded
  std::uint64_t losses = 0;        // hands that had faded out
  std::uint64_t id_changes = 0;    // of the same hand
  std::uint64_t side_changes = 0;  // hands that the tracker took for the other one
  std::uint64_t artefacts = 0;     // samples left out
  std::uint64_t jumps = 0;         // steps that no hand makes (palmJumps), or makes under a new id
  std::uint64_t doubles = 0;       // hands left out beside another one of their side
};

/// Turns what a tracker says into hands that the clay can feel. State is kept by side, not by id:
///
/// - poses pass a One-Euro filter, which starts anew when a hand returns;
/// - a hand that is not seen is held for `hold`, and fades out until `gone`: it grows thin about its bones,
/// to half
///   its radii, so that skin and touch withdraw from the clay, and its confidence falls to zero;
/// - what was held or left out while the tracker's hand went on catches up with it: the cleaned palm is
/// nowhere faster than
///   1.15 times the fastest that the tracker has shown, and so never leaps where the hand did not;
/// - another id, of a hand seen less than `same_hand_time` ago and closer than `same_hand_distance` to where
/// it was, is
///   the same hand, and a step that this makes is blended over `blend`; farther away, or in a jump that no
///   hand makes, it is another hand, which is there from its second sample on;
/// - an id that changes sides in its place takes its hand along;
/// - of several hands of one side, as where a tracker takes the other hand for it, the one that was there
/// before counts: that of its id, or else the nearest; of a side that had none, the most confident;
/// - a step of an unsure hand that its motion does not explain is an artefact, and left out as if the hand
/// was not seen. A
///   stroke is none, however fast: it goes on as it went before, or as it goes from there on;
/// - a joint that is missing is so at once, and starts anew when it is back.
class HandCleaner {
 public:
  /// @throws std::invalid_argument as validate
  explicit HandCleaner(const CleanConfig& config);

  /// Replaces the settings; hands go on as they are.
  /// @throws std::invalid_argument as validate, and keeps them
  void configure(const CleanConfig& config);

  /// Cleans the hands of a frame in place; what it leaves is at most one a side, the left one first. Hands
  /// are sane (hand_check); stamps increase.
  void clean(TrackedFrame& frame);
  /// What is left of the hands at the stamp of `frame`, of which the tracker has sent nothing. While its next
  /// frame is not due (of a slow one, up to 0.07 s), they are held.
  void hold(TrackedFrame& frame);

  /// True while hands are there, seen or not.
  bool present() const {
    return (tracks_[0] && tracks_[0]->presence > 0.0) || (tracks_[1] && tracks_[1]->presence > 0.0);
  }
  const CleanCounts& counts() const { return counts_; }

 private:
  struct Step {  // of a joint, from where it was expected to where it was seen
    Eigen::Vector3d position;
    Eigen::Vector3d rotation;  // vector, rad
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
    TrackedHand seen;                  // as it came
    TrackedHand blended;               // and without what is left of the step of a changed id
    TrackedHand clean;                 // and filtered
    TrackedHand released;              // and predicted
    std::chrono::nanoseconds stamp;    // when it was seen
    std::chrono::nanoseconds updated;  // when it was seen or missed
    double presence = 1.0;             // 0-1
    bool shown = true;                 // false: it jumped there, and was seen there once only
    Eigen::Vector3d velocity =
        Eigen::Vector3d::Zero();      // m/s, of the palm between the last two that were seen
    double fastest = 0.0;             // m/s, of it since the track began
    std::optional<LeftOut> left_out;  // the last artefact since `stamp`
    std::array<OneEuro<3>, joint_count> position;
    std::array<OneEuroRotation, joint_count> orientation;
    std::array<Motion, joint_count> motion;
    std::optional<std::array<Step, joint_count>> steps;  // of a changed id, at blend_start
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
