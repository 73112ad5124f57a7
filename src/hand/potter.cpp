#include <cmath>
#include <limits>
#include <stdexcept>

#include "hand/choreography.h"
#include "hand/placed_hand.h"

namespace tactile_clay::hand {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

/// Fingers forward, palm to the axis, thumb up. The hand is opened by the angle at which it does not squeeze
/// the clay out to the front or to the back. Its skin touches a cone with `distance` as its radius at half
/// the height, m, and its lowest skin is at height z, m.
HandPose beside(const Potter& p, Side side, double distance, double z) {
  const double away = side == Side::left ? 1.0 : -1.0;  // the right hand is at -y
  Eigen::Matrix3d rotation;
  rotation << Vector3d(0.0, 0.0, away), Vector3d(0.0, away, 0.0), -Vector3d::UnitX();
  rotation = AngleAxisd(away * 4 * degree, Vector3d::UnitZ()) * AngleAxisd(away * p.lean, Vector3d::UnitX()) *
             rotation;
  HandPose pose = placed(curled(side, p.scale, 10 * degree, 15 * degree, 10 * degree),
                         Eigen::Isometry3d(rotation), middle_proximal, {0.0, 0.0, z});
  const auto gap = [&](double y) {
    pose.wrist.translation().y() = away * y;
    return smallest(forwardKinematics(pose), [&](const Vector3d& c, double r) {
      return c.head<2>().norm() + (c.z() - 0.5 * p.height) * std::tan(p.lean) - r / std::cos(p.lean);
    });
  };
  gap(bisect(0.0, distance + 0.3, [&](double y) { return gap(y) < distance; }));
  return pose;
}

/// The hand with its thumb across the clay.
/// @param bent rad, flexion of the thumb's first joint
HandPose thumbAcross(HandPose pose, double bent) {
  pose.fingers[0].flexion = {bent, 20 * degree, 10 * degree};
  pose.fingers[0].abduction = 16 * degree;
  return pose;
}

constexpr double thumb_up = -5 * degree, thumb_down = 35 * degree;  // flexion of its first joint

/// The hand whose thumb touches the height `top` in the inner half of the clay, m.
HandPose thumbOn(const Potter& p, const HandPose& pose) {
  const auto lowest = [&](double bent) {
    return smallest(forwardKinematics(thumbAcross(pose, bent)), [&](const Vector3d& c, double r) {
      return c.head<2>().norm() < 0.6 * p.radius ? c.z() - r : std::numeric_limits<double>::infinity();
    });
  };
  if (lowest(thumb_up) < p.top || lowest(thumb_down) > p.top)
    throw std::invalid_argument("potter: the thumbs of these hands cannot press the top to this height");
  return thumbAcross(pose, bisect(thumb_up, thumb_down, [&](double bent) { return lowest(bent) > p.top; }));
}

}  // namespace

Score potter(const Potter& p) {
  if (!(p.scale > 0.0 && p.radius > p.depth && p.depth >= 0.0 && p.height > 0.0 && p.low >= 0.0 &&
        p.rise >= 0.0 && std::abs(p.lean) <= 45 * degree && p.top >= 0.0))
    throw std::invalid_argument(
        "potter: expected positive scale and height, a depth below the radius, low, rise and top of 0 or "
        "more, and a lean of at most 0.785");
  Score score;
  for (const Side side : {Side::left, Side::right}) {
    const double low = p.low, high = p.low + p.rise * p.height;
    const auto at = [&](double distance, double z) {
      const HandPose pose = beside(p, side, distance, z);
      return p.top > 0.0 ? thumbAcross(pose, thumb_up) : pose;
    };
    const HandPose open = at(p.radius + 0.04, low), pressed = at(p.radius - p.depth, low);
    std::vector<Keyframe>& keys = score.hands.emplace_back();
    keys = {{0.0, open}, {0.5, open}, {1.5, at(p.radius, low)}, {3.5, pressed}, {4.5, pressed}};
    if (p.top > 0.0) {
      const HandPose around = at(p.radius - 0.3 * p.depth, high), cover = thumbOn(p, around);
      for (const HandPose& pose : {around, cover, cover, around})
        keys.push_back({keys.back().time + 1.5, pose});
    } else {
      keys.push_back({6.0, at(p.radius - 0.8 * p.depth, high)});
      keys.push_back({7.0, at(p.radius + 0.01, high)});
    }
    keys.push_back({keys.back().time + 1.0, at(p.radius + 0.04, high)});
  }
  return score;
}

}  // namespace tactile_clay::hand
