#include "hand/finger_yield.h"

#include <gtest/gtest.h>

namespace tactile_clay::hand::finger_yield_test {
namespace {

constexpr int index_finger = 1;
constexpr std::array<bool, finger_count> none{};
constexpr std::array<bool, finger_count> at_index{false, true};

// After flesh of the index finger has been inside out for 0.2 s, and the finger has yielded for 0.1 s.
FingerYields yieldedAt(const TrackedHand& hand) {
  FingerYields yields;
  addStep(yields, at_index, 0.2);
  yield(yields, hand, {}, 0.1);
  return yields;
}

TEST(FingerYield, ComesOnceFleshStaysInsideOut) {
  FingerYields yields;
  addStep(yields, at_index, 0.06);
  yield(yields, {}, {}, 0.1);
  EXPECT_EQ(yields[index_finger].reach, 1.0) << "not after 0.06 s";
  addStep(yields, at_index, 0.06);
  yield(yields, {}, {}, 0.1);
  for (int f = 0; f < finger_count; ++f)
    EXPECT_NEAR(yields[f].reach, f == index_finger ? 0.7 : 1.0, 1e-12) << "3 of its reach in a second";
  yield(yields, {}, {}, 10.0);
  EXPECT_EQ(yields[index_finger].reach, 0.0);
}

TEST(FingerYield, IsOverOnceTheFingerIsTrackedElsewhereInThePalm) {
  TrackedHand hand;
  FingerYields yields = yieldedAt(hand);
  addStep(yields, none, 1.0);
  yield(yields, hand, {}, 0.05);
  EXPECT_NEAR(yields[index_finger].reach, 0.7, 1e-12) << "of the same pose";
  BodyPose palm;
  palm.position.x() = 1.0;
  for (JointPose& joint : hand.joints) joint.position.x() += 1.0;
  yield(yields, hand, palm, 0.05);
  EXPECT_NEAR(yields[index_finger].reach, 0.7, 1e-12) << "of a hand that was moved as a whole";
  hand.joints[index_tip].position.z() += 6e-3;
  yield(yields, hand, palm, 0.05);
  EXPECT_NEAR(yields[index_finger].reach, 0.85, 1e-12);
}

TEST(FingerYield, IsForgottenSlowly) {
  FingerYields yields;
  addStep(yields, at_index, 0.2);
  addStep(yields, none, 1.0);
  EXPECT_NEAR(yields[index_finger].inside_out, 0.08, 1e-12);
  addStep(yields, none, 10.0);
  EXPECT_EQ(yields[index_finger].inside_out, 0.0);
}

}  // namespace
}  // namespace tactile_clay::hand::finger_yield_test
