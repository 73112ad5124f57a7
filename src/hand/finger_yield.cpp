#include "hand/finger_yield.h"

#include <algorithm>

#include "hand/reach.h"

namespace tactile_clay::hand {
namespace {

// If flesh is inside out for so long, no hand can take the pose.
constexpr double patience = 0.1;         // s
constexpr double forgotten_time = 0.02;  // s, taken off this time in each second without flesh inside out
constexpr double yielding = 3.0;    // share of its reach that a finger gives up, or gets back, per second
constexpr double elsewhere = 5e-3;  // m; if a joint moves by more in the palm, the pose is another one

}  // namespace

void addStep(FingerYields& yields, const std::array<bool, finger_count>& inside_out, double h) {
  for (int f = 0; f < finger_count; ++f)
    yields[f].inside_out =
        std::clamp(yields[f].inside_out + (inside_out[f] ? h : -forgotten_time * h), 0.0, patience);
}

void yield(FingerYields& yields, const TrackedHand& tracked, const BodyPose& palm, double dt) {
  for (int f = 0; f < finger_count; ++f) {
    FingerYield& y = yields[f];
    Eigen::Matrix<double, 3, 5> joints = Eigen::Matrix<double, 3, 5>::Zero();
    for (int i = 0; i < fingers[f].count; ++i)
      joints.col(i) = palm.rotation.conjugate() * (tracked.joints[fingers[f][i]].position - palm.position);
    if (y.inside_out >= patience) {
      y.reach = std::max(0.0, y.reach - yielding * dt);
      y.joints = joints;
    } else if ((joints - y.joints).colwise().norm().maxCoeff() > elsewhere) {
      y.reach = std::min(1.0, y.reach + yielding * dt);
    }
  }
}

TrackedHand withinReach(const TrackedHand& tracked, const FingerYields& yields) {
  std::array<double, finger_count> share;
  for (int f = 0; f < finger_count; ++f) share[f] = yields[f].reach;
  return withinReach(tracked, share);
}

}  // namespace tactile_clay::hand
