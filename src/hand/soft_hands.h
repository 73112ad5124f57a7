#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "hand/kinematic_hand.h"
#include "hand/soft_hand.h"

namespace tactile_clay::hand {

/// Soft hands for those that are tracked: the interface of KinematicHands, and the way back. The flesh of a
/// hand is made when it is seen, from a mesh and a skin that are there before. Flesh is whole between the
/// thumb and the palm: it has no samples of what the thumb covers at rest.
class SoftHands {
 public:
  /// @throws std::invalid_argument with one line where spacing (1 to 20 mm) or a parameter is out of range
  explicit SoftHands(double spacing, const SoftHandParameters& parameters = {});

  /// As KinematicHands::update; the hand then is where flesh, clay and tracked pose let it be, and the skin
  /// tells of each sample where it is on the tracked hand: there it is felt.
  Skin update(const std::vector<TrackedHand>& hands_in_world, std::chrono::nanoseconds stamp);

  /// Forces of the clay on the skin of `stamp`. They act until the next ones come, at most 0.1 s. Forces that
  /// are not finite or of no sample are left out, stronger ones than 5 N cut, and all of a hand to 50 N or 4
  /// % more than before, at most 120 N.
  /// @return how many were left out; forces on a skin that is not remembered (the last 16 are) are all of
  /// them
  std::size_t react(std::chrono::nanoseconds stamp, const std::vector<SkinForce>& forces);

  const SoftHand* hand(Side side) const {
    return hands_[static_cast<int>(side)] ? &hands_[static_cast<int>(side)]->soft : nullptr;
  }

 private:
  struct Present {
    SoftHand soft;
    std::shared_ptr<const SkinTemplate> skin_template;
    std::chrono::nanoseconds stamp;
    std::uint64_t since;  // number of the skin in which it appeared
    Skin skin;            // the last one
  };
  struct Past {
    std::chrono::nanoseconds stamp;
    std::uint64_t number;
    std::array<std::vector<Eigen::Vector3f>, 2> points;  // by side
    std::array<std::vector<std::uint32_t>, 2> shown;     // samples that the skin has, by side
  };

  SoftHandParameters parameters_;
  SkinTemplates skins_;
  std::array<std::shared_ptr<const SoftHandTemplate>, 2> templates_;  // by side
  std::array<std::optional<Present>, 2> hands_;
  std::deque<Past> past_;
  std::uint64_t number_ = 0;
  std::chrono::nanoseconds loads_stamp_{0};
};

}  // namespace tactile_clay::hand
