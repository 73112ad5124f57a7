#include "hand/handedness.h"

#include <vector>

#include "hand/anatomy.h"
#include "hand/joint_fault.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

// Sines of angles: the lowest one of the palm's +Y to the plane of wrist and knuckles, and the highest mean
// one by which fingers bend back.
constexpr double contrary_palm = -0.2, bent_back = 0.6;

}  // namespace

std::string faultOfSide(const TrackedHand& hand, double scale) {
  const auto at = [&](int joint) -> const Vector3d& { return hand.joints[joint].position; };
  const auto there = [&](int joint) { return !hand.missing[joint]; };
  std::vector<int> knuckles;
  for (int f = 1; f < finger_count; ++f)
    if (there(fingers[f][1])) knuckles.push_back(f);
  // Three fingers have at least two knuckles beside that of the thumb.
  const Vector3d across = at(fingers[knuckles.back()][1]) - at(fingers[knuckles.front()][1]);
  Vector3d middle = Vector3d::Zero();
  for (const int f : knuckles) middle += at(fingers[f][1]) / static_cast<double>(knuckles.size());
  for (std::size_t i = 1; i < knuckles.size(); ++i) {
    const Joint joint = fingers[knuckles[i]][1];
    if ((at(joint) - at(fingers[knuckles[i - 1]][1])).dot(across) <= 0.0)
      return jointFault(joint, "beside the knuckle", finger_names[knuckles[i - 1]],
                        "the knuckles in the order index, middle, ring, little");
  }
  const Vector3d ahead = middle - at(wrist);
  if (ahead.dot(at(palm) - at(wrist)) <= 0.0)
    return "joint palm: it lies behind the wrist, expected between wrist and knuckles";
  const double sign = hand.side == Side::right ? 1.0 : -1.0;
  const char* expected = hand.side == Side::right ? "those of a right hand (a left one, or mirrored?)"
                                                  : "those of a left hand (a right one, or mirrored?)";
  const Vector3d back = sign * across.cross(ahead).normalized();
  const double dorsal = (hand.joints[palm].orientation.normalized() * Vector3d::UnitY()).dot(back);
  if (dorsal < contrary_palm)
    return jointFault(palm, "sine of its +Y to the back of the hand", dorsal,
                      std::string("knuckles and +Y ") + expected);
  double bent = 0.0;
  int count = 0;
  for (int f = 1; f < finger_count; ++f) {
    if (!there(fingers[f].tip())) continue;
    double length = 0.0;
    for (int i = 2; i < fingers[f].count; ++i) length += scale * joint_anatomy[fingers[f][i]].bone_length;
    bent += (at(fingers[f].tip()) - at(fingers[f][1])).dot(back) / length;
    ++count;
  }
  if (count > 0 && bent > bent_back * count)
    return jointFault(middle_tip, "fingers bent back by a sine of", bent / count,
                      std::string("fingers ") + expected);
  return {};
}

}  // namespace tactile_clay::hand
