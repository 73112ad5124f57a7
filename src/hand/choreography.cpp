#include "hand/choreography.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "hand/placed_hand.h"

namespace tactile_clay::hand {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr int max_repeats = 1000;  // of a stroke: over an hour of kneading

bool repeats(int times) {
  return times > 0 && times <= max_repeats;
}

// State of a hand that kneads.
struct Stroke {
  double grip;   // 0 open to 1 curled, stretched below 0
  double pitch;  // rad, fingers down
  double x;      // m, of the palm
  double z;      // m, of the lowest skin
};

HandPose strokePose(Side side, double scale, double y, const Stroke& stroke) {
  const double g = stroke.grip;
  return placed(curled(side, scale, (5 + 30 * g) * degree, (5 + 40 * g) * degree, (5 + 20 * g) * degree),
                palmDown(stroke.pitch), palm, {stroke.x, y, stroke.z});
}

// Between two strokes the lowest skin moves evenly, too. Interpolated wrist poses would not do that, because
// the hand rolls.
void addMotion(std::vector<Keyframe>& keys, double scale, double y, const Stroke& from, const Stroke& to,
               double seconds) {
  constexpr int steps = 8;
  const double start = keys.back().time;
  const Side side = keys.back().pose.side;
  for (int i = 1; i <= steps; ++i) {
    const double s = eased(Ease::minimum_jerk, static_cast<double>(i) / steps);
    const Stroke now{from.grip + s * (to.grip - from.grip), from.pitch + s * (to.pitch - from.pitch),
                     from.x + s * (to.x - from.x), from.z + s * (to.z - from.z)};
    keys.push_back({start + seconds * i / steps, strokePose(side, scale, y, now), Ease::steady});
  }
}

// From `approach` above a pose that just touches, down to `depth` below it, and up again.
Score press(const HandPose& touching, const PressFinger& p) {
  if (!(p.speed > 0.0 && p.depth >= 0.0 && p.hold >= 0.0 && p.approach > 0.0 && p.scale > 0.0))
    throw std::invalid_argument(
        "press: expected positive speed, approach and scale, depth and hold of 0 or more");
  constexpr double pause = 0.3;  // s, at rest at both ends
  constexpr double reach = 1.0;  // s, between rest and touch
  const HandPose above = lifted(touching, p.approach);
  const HandPose below = lifted(touching, -p.depth);
  double t = pause;
  Score score;
  std::vector<Keyframe>& keys = score.hands.emplace_back();
  keys.push_back({0.0, above});
  keys.push_back({t, above});
  keys.push_back({t += reach, touching});
  keys.push_back({t += p.depth / p.speed, below, Ease::steady});
  keys.push_back({t += p.hold, below});
  keys.push_back({t += reach, above});
  keys.push_back({t + pause, above});
  return score;
}

// The hand raised so that its lowest skin over the block touches its top. Lower skin may hang beside it.
HandPose onBlock(const HandPose& pose, const PressFinger& p) {
  constexpr double half_width = 0.02;  // m, of the block
  const double lowest = smallest(forwardKinematics(pose), [&](const Vector3d& centre, double radius) {
    const Eigen::Vector2d beside =
        ((centre.head<2>() - p.centre).cwiseAbs().array() - half_width).cwiseMax(0.0);
    // Square of the sphere's depth over the nearest point of the block.
    const double square = radius * radius - beside.squaredNorm();
    return square > 0.0 ? centre.z() - std::sqrt(square) : std::numeric_limits<double>::infinity();
  });
  return lifted(pose, p.block_height - lowest);
}

// A hand that pinches, from open (0) to closed (1). The two fingers that do not grip are folded away.
HandPose grip(double scale, double closed) {
  HandPose pose = curled(Side::right, scale, (30 + 25 * closed) * degree, (25 + 30 * closed) * degree,
                         (15 + 10 * closed) * degree);
  pose.fingers[0].flexion = {(15 + 20 * closed) * degree, 10 * degree * closed, 20 * degree * closed};
  pose.fingers[0].abduction = 20 * degree;
  pose.fingers[3].flexion = pose.fingers[4].flexion = {95 * degree, 95 * degree, 60 * degree};
  return pose;
}

// Middle of the tips of the two fingers that grip.
Vector3d fingertips(const TrackedHand& hand) {
  return 0.5 * (hand.joints[index_tip].position + hand.joints[middle_tip].position);
}

// Gap between the skins of thumb and fingers, m.
double gapOf(const TrackedHand& hand) {
  return (fingertips(hand) - hand.joints[thumb_tip].position).norm() - hand.joints[thumb_tip].radius -
         hand.joints[index_tip].radius;
}

// The grip whose gap has this width, m.
HandPose gripOf(double scale, double width) {
  const double open = 0.0, closed = 1.0;
  if (gapOf(forwardKinematics(grip(scale, open))) < width ||
      gapOf(forwardKinematics(grip(scale, closed))) > width)
    throw std::invalid_argument("pinch: this hand cannot grip " + std::to_string(width) + " m");
  const auto narrow = [&](double share) { return !(gapOf(forwardKinematics(grip(scale, share))) > width); };
  return grip(scale, bisect(closed, open, narrow));
}

// The thumb to the left of the block, the fingers to its right, all pointing down into it.
HandPose overBlock(const Pinch& p, const HandPose& pose) {
  const TrackedHand hand = forwardKinematics(pose);
  const Vector3d across = (fingertips(hand) - hand.joints[thumb_tip].position).normalized();
  Vector3d down = -(hand.joints[index_tip].orientation * Vector3d::UnitZ() +
                    hand.joints[thumb_tip].orientation * Vector3d::UnitZ());
  down = (down - down.dot(across) * across).normalized();
  const Eigen::Matrix3d rotation = Vector3d::UnitX() * across.cross(down).transpose() -
                                   Vector3d::UnitY() * across.transpose() -
                                   Vector3d::UnitZ() * down.transpose();
  HandPose at = placed(pose, Eigen::Isometry3d(rotation), index_tip, {0.0, 0.0, p.block_height - p.reach});
  const TrackedHand turned = forwardKinematics(at);
  const Vector3d middle = 0.5 * (fingertips(turned) + turned.joints[thumb_tip].position);
  at.wrist.pretranslate(Vector3d(p.centre.x() - middle.x(), p.centre.y() - middle.y(), 0.0));
  return at;
}

}  // namespace

Score knead(const Knead& p) {
  if (!(p.scale > 0.0 && p.depth >= 0.0 && p.block_height > p.depth && repeats(p.strokes)))
    throw std::invalid_argument(
        "knead: expected positive scale, 1 to 1000 strokes, and a depth below the block's height");
  constexpr double travel = 1.2;  // s, between outside and over the blocks
  const double pressed = p.block_height - p.depth;
  const Stroke hover{0.0, 0.0, -0.04, p.block_height + 0.05};
  Score score;
  for (const Side side : {Side::left, Side::right}) {
    const double out = side == Side::left ? 1.0 : -1.0;
    const double y = out * p.aside;
    const HandPose over = strokePose(side, p.scale, y, hover);
    HandPose outside = over;
    outside.wrist.pretranslate(Vector3d(-0.28, 0.1 * out, 0.08));
    std::vector<Keyframe>& keys = score.hands.emplace_back();
    keys.push_back({0.0, outside});
    keys.push_back({side == Side::left ? 0.2 : 0.95, outside});  // the hands take turns
    keys.push_back({keys.back().time + travel, over});
    for (int i = 0; i < p.strokes; ++i) {
      const double x = i % 2 == 0 ? -0.045 : -0.055;
      const Stroke heel{0.0, -12 * degree, x + 0.035, pressed};
      const Stroke flat{-0.25, 5 * degree, x + 0.015, pressed};
      const Stroke tips{0.1, 18 * degree, x, pressed};
      const Stroke grip{0.7, 12 * degree, x + 0.03, pressed};
      const Stroke drawn{0.7, 12 * degree, x + 0.03 - p.draw, pressed};
      const Stroke* last = &hover;
      for (const auto& [next, seconds] :
           {std::pair(&heel, 0.9), std::pair(&flat, 0.7), std::pair(&tips, 0.7), std::pair(&grip, 0.6),
            std::pair(&drawn, 0.6), std::pair(&hover, 0.9)}) {
        addMotion(keys, p.scale, y, *last, *next, seconds);
        last = next;
      }
    }
    keys.push_back({keys.back().time + travel, outside});
  }
  return score;
}

Score pressFinger(const PressFinger& p) {
  HandPose pose = curled(Side::right, p.scale, 0.0, 0.0, 0.0);
  pose.fingers[1].flexion = {55 * degree, 20 * degree, 10 * degree};
  return press(placed(pose, palmDown(0.0), index_tip, {p.centre.x(), p.centre.y(), p.block_height}), p);
}

Score pressThumb(const PressFinger& p) {
  // The thumb sticks out of a fist to the front. At this angle nothing else of the fist is over the block.
  constexpr double pitch = 24 * degree, tilt = -15 * degree;
  HandPose pose = curled(Side::right, p.scale, 90 * degree, 90 * degree, 54 * degree);
  pose.fingers[0].flexion = {-5 * degree, -25 * degree, 0.0};
  pose.fingers[0].abduction = 18 * degree;
  const Eigen::Quaterniond thumb(forwardKinematics(pose).joints[thumb_tip].orientation);
  const Eigen::Isometry3d pad_down = palmDown(pitch) * AngleAxisd(-tilt, Vector3d::UnitZ());
  return press(
      onBlock(placed(pose, pad_down * thumb.inverse(), thumb_tip, {p.centre.x(), p.centre.y(), 0.0}), p), p);
}

Score flatPress(const PressFinger& p) {
  // Heel and ball of the thumb hang beside the block, which is level with the front of the palm.
  return press(onBlock(placed(curled(Side::right, p.scale, 0.0, 0.0, 0.0), palmDown(0.0), palm,
                              {p.centre.x() - 0.015 * p.scale, p.centre.y(), 0.0}),
                       p),
               p);
}

Score pinch(const Pinch& p) {
  if (!(p.scale > 0.0 && p.approach > 0.0 && p.reach >= 0.0 && p.depth >= 0.0 && p.width > p.depth &&
        repeats(p.times)))
    throw std::invalid_argument(
        "pinch: expected positive scale and approach, 1 to 1000 times, reach of 0 or more, and a depth below "
        "the width");
  const HandPose open = overBlock(p, gripOf(p.scale, p.width + 0.01));
  const HandPose closed = overBlock(p, gripOf(p.scale, p.width - p.depth));
  double t = 0.3;
  Score score;
  std::vector<Keyframe>& keys = score.hands.emplace_back();
  keys.push_back({0.0, lifted(open, p.approach)});
  keys.push_back({t, lifted(open, p.approach)});
  keys.push_back({t += 1.0, open});
  for (int i = 0; i < p.times; ++i) {
    keys.push_back({t += 0.6, closed});
    keys.push_back({t += 0.4, closed});
    keys.push_back({t += 0.5, open});
  }
  keys.push_back({t += 1.0, lifted(open, p.approach)});
  keys.push_back({t + 0.3, lifted(open, p.approach)});
  return score;
}

Score roll(const Roll& p) {
  if (!(p.scale > 0.0 && p.approach > 0.0 && p.depth >= 0.0 && p.travel >= 0.0 && repeats(p.times)))
    throw std::invalid_argument(
        "roll: expected positive scale and approach, 1 to 1000 times, depth and travel of 0 or more");
  PressFinger press;
  press.scale = p.scale;
  press.centre = p.centre;
  press.block_height = p.block_height;
  const HandPose touching = flatPress(press).hands.at(0).at(2).pose;
  const auto at = [&](double x, double z) {
    HandPose pose = touching;
    pose.wrist.pretranslate(Vector3d(x, 0.0, z));
    return pose;
  };
  double t = 0.3;
  Score score;
  std::vector<Keyframe>& keys = score.hands.emplace_back();
  keys.push_back({0.0, at(-p.travel, p.approach)});
  keys.push_back({t, at(-p.travel, p.approach)});
  keys.push_back({t += 1.0, at(-p.travel, 0.0)});
  keys.push_back({t += 0.4, at(-p.travel, -p.depth)});
  for (int i = 0; i < p.times; ++i) {
    keys.push_back({t += 0.8, at(p.travel, -p.depth)});
    keys.push_back({t += 0.8, at(-p.travel, -p.depth)});
  }
  keys.push_back({t += 1.0, at(-p.travel, p.approach)});
  keys.push_back({t + 0.3, at(-p.travel, p.approach)});
  return score;
}

}  // namespace tactile_clay::hand
