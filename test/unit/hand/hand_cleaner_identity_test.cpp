#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "cleaned_hands.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_pose.h"

namespace tactile_clay::hand::hand_cleaner_identity_test {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector3d;

TEST(HandCleaner, AChangeOfIdAloneIsNotFelt) {
  HandCleaner plain(CleanConfig{}), changing(CleanConfig{});
  double worst = 0.0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d at(0.2 * std::sin(0.03 * i), 0.1 * std::cos(0.05 * i), 0.0);  // up to 0.8 m/s
    const TrackedFrame expected = cleaned(plain, i * 10ms, {handAt(at)});
    const TrackedFrame out = cleaned(changing, i * 10ms, {handAt(at, 1 + i / 40)});
    ASSERT_EQ(out.hands.size(), 1U);
    EXPECT_EQ(out.hands[0].id, 1U + i / 40);
    worst = std::max(worst, (palmOf(out) - palmOf(expected)).norm());
  }
  EXPECT_EQ(changing.counts().id_changes, 4U);
  EXPECT_EQ(changing.counts().dropouts + changing.counts().losses, 0U);
  // With a blend that ignored the motion it would be some 5 mm.
  EXPECT_LT(worst, 0.001);
}

TEST(HandCleaner, TheStepOfANewIdIsBlended) {
  HandCleaner cleaner(unfiltered());
  for (int i = 0; i < 10; ++i) cleaned(cleaner, i * 10ms, {handAt(Vector3d::Zero(), 1)});
  const Vector3d step(0.03, 0.0, 0.0);
  Vector3d last = handAt(Vector3d::Zero()).joints[palm].position;
  const Vector3d goal = last + step;
  for (int i = 0; i <= 10; ++i) {
    const TrackedFrame out = cleaned(cleaner, 100ms + i * 10ms, {handAt(step, 2)});
    EXPECT_LE((palmOf(out) - last).norm(), 0.0031) << i;
    last = palmOf(out);
  }
  EXPECT_LT((last - goal).norm(), 1e-12);
  EXPECT_EQ(cleaner.counts().id_changes, 1U);
}

TEST(HandCleaner, ANewIdElsewhereIsAnotherHand) {
  HandCleaner cleaner(CleanConfig{});
  for (int i = 0; i < 10; ++i) cleaned(cleaner, i * 10ms, {handAt(Vector3d::Zero(), 1)});
  const TrackedHand other = handAt({0.06, 0.0, 0.0}, 2);
  EXPECT_TRUE(cleaned(cleaner, 100ms, {other}).hands.empty());
  EXPECT_EQ(palmOf(cleaned(cleaner, 110ms, {other})), other.joints[palm].position);
  EXPECT_EQ(cleaner.counts().id_changes, 0U);
  EXPECT_EQ(cleaner.counts().jumps, 1U);
}

TEST(HandCleaner, AnUnsureLeapIsAnArtefactAThrowIsNot) {
  for (const double confidence : {1.0, 0.6, 0.4}) {
    HandCleaner cleaner(unfiltered());
    cleaned(cleaner, 0ms, {handAt(Vector3d::Zero(), 1, Side::right, confidence)});
    const TrackedHand leaped = handAt({0.02, 0.0, 0.0}, 1, Side::right, confidence);  // 2 m/s
    const TrackedFrame out = cleaned(cleaner, 10ms, {leaped});
    const bool artefact = confidence < 0.5;
    EXPECT_EQ(palmOf(out),
              artefact ? handAt(Vector3d::Zero()).joints[palm].position : leaped.joints[palm].position);
    EXPECT_EQ(cleaner.counts().artefacts, artefact ? 1U : 0U);
    // A hand that stays there is accepted there.
    TrackedFrame later;
    for (int i = 2; i < 15; ++i) later = cleaned(cleaner, i * 10ms, {leaped});
    EXPECT_EQ(palmOf(later), leaped.joints[palm].position);
  }
}

TEST(HandCleaner, AJumpOfAMetreIsNotAStroke) {
  HandCleaner cleaner(CleanConfig{});
  for (int i = 0; i < 10; ++i) cleaned(cleaner, i * 10ms, {handAt(Vector3d::Zero())});
  const TrackedHand far = handAt({1.0, 0.0, 0.0});
  EXPECT_TRUE(cleaned(cleaner, 100ms, {far}).hands.empty());
  EXPECT_EQ(palmOf(cleaned(cleaner, 110ms, {far})), far.joints[palm].position);
  EXPECT_EQ(cleaner.counts().jumps, 1U);
  // A hand that jumps to and fro is not accepted anywhere.
  for (int i = 12; i < 30; ++i)
    EXPECT_TRUE(cleaned(cleaner, i * 10ms, {i % 2 == 0 ? handAt(Vector3d::Zero()) : far}).hands.empty()) << i;
}

TEST(HandCleaner, AHandTakenForTheOtherOneIsNotThereTwice) {
  HandCleaner cleaner(CleanConfig{});
  cleaned(cleaner, 0ms, {handAt(Vector3d::Zero(), 5, Side::left)});
  TrackedFrame out = cleaned(cleaner, 10ms, {handAt(Vector3d::Zero(), 5, Side::right)});
  ASSERT_EQ(out.hands.size(), 1U);
  EXPECT_EQ(out.hands[0].side, Side::right);
  EXPECT_EQ(cleaner.counts().side_changes, 1U);
  // Another hand that appears does not end the one that is held.
  HandCleaner two(CleanConfig{});
  cleaned(two, 0ms, {handAt(Vector3d::Zero(), 5, Side::left)});
  out = cleaned(two, 10ms, {handAt({0.0, 0.3, 0.0}, 6, Side::right)});
  ASSERT_EQ(out.hands.size(), 2U);
  EXPECT_EQ(out.hands[0].side, Side::left);
}

// A tracker takes the left hand for a second right one, and names it first: the right one stays where it is.
TEST(HandCleaner, OfTwoHandsOfASideTheOneThatWasThereStays) {
  HandCleaner cleaner(unfiltered());
  const TrackedHand own = handAt(Vector3d::Zero(), 5), other = handAt({0.0, 0.3, 0.0}, 6);
  cleaned(cleaner, 0ms, {own});
  for (int i = 1; i < 20; ++i) {
    const bool first = i % 2 == 0;
    const TrackedFrame out = cleaned(cleaner, i * 10ms, {first ? own : other, first ? other : own});
    ASSERT_EQ(out.hands.size(), 1U);
    EXPECT_EQ(out.hands[0].id, 5U) << i;
    EXPECT_EQ(palmOf(out), own.joints[palm].position) << i;
  }
  // Under a new id it is still the nearest.
  const TrackedFrame out = cleaned(cleaner, 200ms, {other, handAt(Vector3d::Zero(), 7)});
  EXPECT_EQ(out.hands.at(0).id, 7U);
  EXPECT_EQ(cleaner.counts().doubles, 20U);
  EXPECT_EQ(cleaner.counts().jumps, 0U);
  // If there was no hand before, the one with the highest confidence is taken.
  HandCleaner fresh(unfiltered());
  EXPECT_EQ(cleaned(fresh, 0ms, {handAt(Vector3d::Zero(), 1, Side::right, 0.2), handAt({0.3, 0.0, 0.0}, 2)})
                .hands.at(0)
                .id,
            2U);
}

}  // namespace
}  // namespace tactile_clay::hand::hand_cleaner_identity_test
