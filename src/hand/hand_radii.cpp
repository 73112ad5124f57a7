#include "hand/hand_radii.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "hand/anatomy.h"
#include "hand/joint_fault.h"

namespace tactile_clay::hand {
namespace {

// Over the table's radius at the hand's size. Of a single joint: wide, because trackers define the radius of
// palm and wrist in other ways, and a hand that fades out has half its radii (hand_cleaner.cpp).
constexpr double thinnest = 0.2, thickest = 4.0;
// The same for the median of a hand's radii. In recordings of Leap the fingers are 1.19 times as thick as the
// table's. Hands from 0.7 times on may fade to half of it. A hand whose diameters were sent as radii has
// twice its radii: 2.4 times the table's in those recordings.
constexpr double thinnest_hand = 0.35, thickest_hand = 1.8;

double usualRadius(int joint, double scale) {
  return scale * joint_anatomy[joint].radius;
}

// Median of the radii over the table's; a radius that is NaN counts as 0. Palm and wrist are never missing.
double thickness(const TrackedHand& hand, double scale) {
  std::vector<double> ratios;
  for (int joint = 0; joint < joint_count; ++joint) {
    if (hand.missing[joint]) continue;
    const double ratio = hand.joints[joint].radius / usualRadius(joint, scale);
    ratios.push_back(std::isnan(ratio) ? 0.0 : ratio);
  }
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

std::string replaceAll(TrackedHand& hand, double scale, double thick) {
  for (int joint = 0; joint < joint_count; ++joint)
    if (!hand.missing[joint]) hand.joints[joint].radius = usualRadius(joint, scale);
  std::ostringstream line;
  line.precision(3);
  line << "its radii are " << thick << " times those of an adult at its size, expected "
       << range(thinnest_hand, thickest_hand, " times")
       << " (radii in metres, not diameters); all are replaced by those of an adult";
  return line.str();
}

std::string replaceSingle(TrackedHand& hand, double scale) {
  int count = 0;
  std::string fault;
  for (int joint = 0; joint < joint_count; ++joint) {
    if (hand.missing[joint]) continue;
    double& radius = hand.joints[joint].radius;
    const double usual = usualRadius(joint, scale), low = thinnest * usual, high = thickest * usual;
    if (radius >= low && radius <= high) continue;
    if (count++ == 0) fault = jointFault(joint, "radius", radius, range(low, high, " m"));
    radius = usual;
  }
  if (count == 0) return {};
  return std::to_string(count) + " radii are not a hand's and replaced by those of an adult at its size; " +
         fault;
}

}  // namespace

double minimumRadiusFactor(const TrackedHand& hand) {
  constexpr double rounding = 1.0 + 1e-5;  // messages have radii in single precision
  const double scale = personScale(hand);
  double factor = thinnest_hand / thickness(hand, scale);
  for (int joint = 0; joint < joint_count; ++joint)
    if (!hand.missing[joint])
      factor = std::max(factor, thinnest * usualRadius(joint, scale) / hand.joints[joint].radius);
  return std::min(1.0, rounding * factor);
}

std::string replaceRadii(TrackedHand& hand, double scale) {
  const double thick = thickness(hand, scale);
  return thick >= thinnest_hand && thick <= thickest_hand ? replaceSingle(hand, scale)
                                                          : replaceAll(hand, scale, thick);
}

}  // namespace tactile_clay::hand
