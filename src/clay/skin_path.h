#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "values/skin.h"

namespace tactile_clay::clay {

/// The motion of the skin through the frames of a live simulation. In each frame a sample moves from where
/// the frame before left it to its position in the newest message. The number of messages since then, the
/// distance of their stamps and the simulated time of the frame do not matter. With the velocities of the
/// newest message alone the skin would jump between frames, start inside the clay and tear it. Messages of
/// the same length are taken to contain the same samples.
class SkinPath {
 public:
  /// To be called when a message of the skin has come.
  /// @param stamp s, of the clock to which the velocities refer
  void add(Skin skin, double stamp) {
    const bool goes_on = skin.size() == skin_.size();
    const double since = std::clamp(stamp - stamp_, 0.0, longest);
    stamp_ = stamp;
    for (std::size_t k = 0; k < skin.size(); ++k) {
      Eigen::Vector3f& way = skin.velocity[k];
      way *= static_cast<float>(since);
      if (!goes_on) continue;
      // If a message was lost on its way to us, the velocity may be a mean over a shorter time than `since`.
      const float farthest = (skin.position[k] - skin_.position[k]).norm() + withdrawal;
      way *= std::min(farthest / std::max(way.norm(), 1e-9f), 1.0f);
      way += skin_.velocity[k];
    }
    skin_ = std::move(skin);
  }

  /// The newest message, with the velocities that bring its samples to their positions in this frame.
  /// @param duration s, that the frame simulates; if it is 0, the velocities are 0 and the next frame takes
  /// the whole way
  Skin frame(double duration) {
    Skin skin = skin_;
    const float per_second = duration > 0.0 ? static_cast<float>(1.0 / duration) : 0.0f;
    for (Eigen::Vector3f& velocity : skin.velocity) velocity *= per_second;
    if (duration > 0.0) std::fill(skin_.velocity.begin(), skin_.velocity.end(), Eigen::Vector3f::Zero());
    return skin;
  }

 private:
  // m; samples may move back into the hand, at most by the radius of a finger. Their velocities do not
  // contain this motion.
  static constexpr float withdrawal = 0.01f;

  static constexpr double longest = 1.0;  // s; a longer time between messages counts as this one

  double stamp_ = std::numeric_limits<double>::infinity();  // s, of the newest message
  Skin skin_;  // newest message; its velocities are replaced by the ways since the last frame, m
};

}  // namespace tactile_clay::clay
