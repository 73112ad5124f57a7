#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "values/skin.h"

namespace tactile_clay::clay {

/// The way of the skin through the frames of a live simulation. A frame begins where the one before left each
/// sample, and ends where the newest message has it, however many messages came meanwhile, however far apart
/// their stamps are, and however much time the frame simulates. With the velocities of the newest message
/// alone the skin would jump between frames, start within the clay and tear it. Messages of one length are
/// taken to be of the same samples.
class SkinPath {
 public:
  /// A message of the skin came.
  /// @param stamp s, of any clock that the velocities count in
  void add(Skin skin, double stamp) {
    const bool goes_on = skin.size() == skin_.size();
    const double since = std::clamp(stamp - stamp_, 0.0, longest);
    stamp_ = stamp;
    for (std::size_t k = 0; k < skin.size(); ++k) {
      Eigen::Vector3f& way = skin.velocity[k];
      way *= static_cast<float>(since);
      if (!goes_on) continue;
      // Its velocity may be of a shorter time than `since`, where a message was lost on its way to us.
      const float farthest = (skin.position[k] - skin_.position[k]).norm() + withdrawal;
      way *= std::min(farthest / std::max(way.norm(), 1e-9f), 1.0f);
      way += skin_.velocity[k];
    }
    skin_ = std::move(skin);
  }

  /// The newest message, with the velocities that take its samples there in this frame.
  /// @param duration s, that the frame simulates; 0: none, and the next frame takes the whole way
  Skin frame(double duration) {
    Skin skin = skin_;
    const float per_second = duration > 0.0 ? static_cast<float>(1.0 / duration) : 0.0f;
    for (Eigen::Vector3f& velocity : skin.velocity) velocity *= per_second;
    if (duration > 0.0) std::fill(skin_.velocity.begin(), skin_.velocity.end(), Eigen::Vector3f::Zero());
    return skin;
  }

 private:
  // m; samples may withdraw into the hand, by the radius of a finger at most, which is no velocity of theirs.
  static constexpr float withdrawal = 0.01f;

  static constexpr double longest = 1.0;  // s; a way of more is none

  double stamp_ = std::numeric_limits<double>::infinity();  // s, of the newest message
  Skin skin_;  // of the newest message; in place of velocities the ways since the last frame, m
};

}  // namespace tactile_clay::clay
