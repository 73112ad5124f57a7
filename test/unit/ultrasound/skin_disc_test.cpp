// Focal points on skin that is not plane: fingers, curved and beside each other.
#include "ultrasound/skin_disc.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include "ultrasound/focal_points.h"

namespace tactile_clay::ultrasound::skin_disc_test {
namespace {

using contact::PressureSample;
using Eigen::Vector3d;
using Samples = std::vector<PressureSample>;

constexpr double off_skin = 3e-3;  // m, at most, of a focal point
constexpr double height = 0.2;     // m, of the hand above the array

PressureSample sample(const Vector3d& position, const Vector3d& normal, double area,
                      double pressure = 3000.0) {
  const auto p = static_cast<float>(pressure), a = static_cast<float>(area);
  return {position.cast<float>(), normal.cast<float>(), p, p * a, a, 1.0f};
}

/// A finger along y.
struct Finger {
  double x, radius, length = 0.03, z = height;  // m

  /// Signed.
  double distance(const Vector3d& point) const {
    const double y = std::clamp(point.y(), -0.5 * length, 0.5 * length);
    return (point - Vector3d(x, y, z)).norm() - radius;
  }
  /// Adds the pressed samples, up to `reach` rad to either side of the line that faces the array.
  void press(double reach, double pitch, Samples& samples) const {
    const int around = static_cast<int>(reach * radius / pitch),
              along = static_cast<int>(0.5 * length / pitch);
    for (int i = -around; i <= around; ++i)
      for (int j = -along; j <= along; ++j) {
        const double angle = i * pitch / radius;
        const Vector3d normal(std::sin(angle), 0.0, -std::cos(angle));
        samples.push_back(sample(Vector3d(x, j * pitch, z) + radius * normal, normal, pitch * pitch));
      }
  }
};

double fromSkin(const std::vector<Finger>& fingers, const Vector3d& point) {
  double closest = std::numeric_limits<double>::infinity();
  for (const Finger& finger : fingers) closest = std::min(closest, finger.distance(point));
  return std::abs(closest);
}

/// Where fingers reach into each other, places inside a finger are not skin.
void leaveOutCovered(const std::vector<Finger>& fingers, Samples& samples) {
  samples.erase(std::remove_if(samples.begin(), samples.end(),
                               [&](const PressureSample& s) {
                                 return std::any_of(
                                     fingers.begin(), fingers.end(), [&](const Finger& finger) {
                                       return finger.distance(s.position.cast<double>()) < -1e-6;
                                     });
                               }),
                samples.end());
}

Vector3d mean(const Samples& samples) {
  Vector3d sum = Vector3d::Zero();
  for (const PressureSample& s : samples) sum += s.position.cast<double>();
  return sum / static_cast<double>(samples.size());
}

TEST(SkinDisc, IsFlatAndNoWiderThanSkinIs) {
  const SkinDisc disc = skinDisc(sample({0.0, 0.0, height}, -Vector3d::UnitZ(), M_PI * 1e-6));
  EXPECT_NEAR(disc.radius, 1e-3, 1e-8);
  EXPECT_NEAR(disc.distance({0.0, 0.9e-3, height}), 0.0, 1e-8);
  EXPECT_NEAR(disc.distance({0.0, 0.9e-3, height - 2e-3}), 2e-3, 1e-8);
  EXPECT_NEAR(disc.distance({4e-3, 0.0, height + 4e-3}), 5e-3, 1e-8);
  EXPECT_LE(skinDisc(sample({0.0, 0.0, height}, -Vector3d::UnitZ(), 4e-4)).radius, off_skin);
}

TEST(SkinDisc, WithoutANormalIsAPoint) {
  for (const double broken : {0.0, std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    const SkinDisc disc = skinDisc(sample({0.0, 0.0, height}, Vector3d::Constant(broken), 1e-5));
    EXPECT_NEAR(disc.distance({1e-3, 0.0, height}), 1e-3, 1e-8) << broken;
    EXPECT_NEAR(disc.distance({0.0, 0.0, height + 2e-3}), 2e-3, 1e-8) << broken;
  }
}

TEST(SkinDisc, APointOnTheSkinStaysAndOneBesideItIsLedThereWithoutALeap) {
  const std::vector<SkinDisc> skin{skinDisc(sample({0.0, 0.0, height}, -Vector3d::UnitZ(), M_PI * 6.25e-6))};
  for (const Vector3d& way : {Vector3d::UnitX().eval(), Vector3d::UnitZ().eval(), Vector3d(0.6, 0.0, 0.8)}) {
    Vector3d before = skin[0].centre;
    for (double d = 0.0; d < 0.02; d += 1e-4) {
      const Vector3d point = skin[0].centre + d * way, place = ontoSkin(point, skin);
      EXPECT_LE(skin[0].distance(place), skin_tolerance + 1e-12);
      EXPECT_LE((place - skin[0].centre).norm(), farthest_from_sample + 1e-12);
      if (skin[0].distance(point) <= skin_tolerance && d <= farthest_from_sample) {
        EXPECT_EQ(place, point);
      } else if (skin[0].distance(point) > 2.0 * skin_tolerance) {
        EXPECT_EQ(place, skin[0].centre);
      }
      EXPECT_LT((place - before).norm(), 4e-4);
      before = place;
    }
  }
}

// Two fingers that pinch: the disc of one reaches into the other.
TEST(SkinDisc, NoPlaceIsOffTheSkinWhereFingersReachIntoEachOther) {
  std::mt19937 random(5);
  const auto pick = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int pair = 0; pair < 300; ++pair) {
    const double a = pick(5e-3, 10e-3), b = pick(5e-3, 10e-3);
    const std::vector<Finger> fingers{{0.0, a}, {pick(0.0, a + b), b, 0.03, height + pick(-a - b, a + b)}};
    Samples samples;
    for (const Finger& finger : fingers) finger.press(1.57, pick(3e-3, 6e-3), samples);
    leaveOutCovered(fingers, samples);
    std::vector<SkinDisc> skin;
    std::transform(samples.begin(), samples.end(), std::back_inserter(skin), skinDisc);
    if (skin.empty()) continue;
    for (const SkinDisc& disc : skin)
      for (double angle = 0.0; angle < 2.0 * M_PI; angle += 0.4) {
        const Vector3d along =
            Eigen::AngleAxisd(angle, disc.normal) * disc.normal.cross(Vector3d::UnitY()).normalized();
        const Vector3d rim = disc.centre + (disc.radius + 0.99 * skin_tolerance) * along;
        EXPECT_LE(fromSkin(fingers, ontoSkin(rim, skin)), off_skin) << pair << ", " << angle;
      }
  }
}

// The mean of samples around a finger lies inside it.
TEST(FocalPointsOnFingers, LieOnACurvedContact) {
  for (const double radius : {5e-3, 8e-3, 12e-3, 20e-3})
    for (const double reach : {0.3, 0.8, 1.2, 1.57}) {
      Samples samples;
      const std::vector<Finger> finger{{0.0, radius, 0.01}};
      finger[0].press(reach, 2e-3, samples);
      FocalPointConfig config;
      config.max_points = 1;
      const auto points = FocalPointRenderer(config).render(samples);
      ASSERT_EQ(points.size(), 1u);
      EXPECT_LE(fromSkin(finger, points[0].position), off_skin) << radius << ", " << reach;
      if (fromSkin(finger, mean(samples)) < 1e-3) {
        EXPECT_LT((points[0].position - mean(samples)).norm(), 1e-6) << "on the skin it stays where it was";
      }
    }
}

// Contacts that the array cannot resolve get one point: on one of the fingers, not in the air between them.
TEST(FocalPointsOnFingers, OfTwoFingersThatAreOnePointLieOnOne) {
  int between = 0;
  for (const double radius : {6e-3, 8e-3, 10e-3})
    for (const double gap : {-4e-3, -2e-3, 0.0, 1e-3, 4e-3, 10e-3})
      for (const double lift : {0.0, 5e-3, 15e-3}) {
        const std::vector<Finger> fingers{{-radius - 0.5 * gap, radius},
                                          {radius + 0.5 * gap, radius, 0.03, height + lift}};
        Samples samples;
        for (const Finger& finger : fingers) finger.press(gap < 0.0 ? 1.2 : 0.5, 2e-3, samples);
        leaveOutCovered(fingers, samples);
        between += fromSkin(fingers, mean(samples)) > off_skin ? 1 : 0;
        FocalPointConfig config;
        config.max_points = 1;
        const auto points = FocalPointRenderer(config).render(samples);
        ASSERT_EQ(points.size(), 1u);
        EXPECT_LE(fromSkin(fingers, points[0].position), off_skin) << radius << ", " << gap << ", " << lift;
        EXPECT_GT(points[0].pressure, 0.0);
      }
  EXPECT_GT(between, 12) << "of 54 whose mean is in the air";
}

// Hands of any fingers, pressed anyhow, frame after frame, with an array and without.
TEST(FocalPointsOnFingers, LieOnTheSkinOfAnyContact) {
  std::mt19937 random(11);
  const auto pick = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const ArrayReach usx(arrayLayout("usx"), Acoustics());
  double worst = 0.0;
  int checked = 0;
  for (int hand = 0; hand < 60; ++hand) {
    FocalPointConfig config;
    config.max_points = static_cast<std::size_t>(pick(1.0, 9.0));
    FocalPointRenderer renderer(config);
    if (hand % 2 == 0) renderer.setArray(usx);
    std::vector<Finger> fingers;
    double x = -0.04;
    for (int k = 0, count = static_cast<int>(pick(1.0, 6.0)); k < count; ++k) {
      const double radius = pick(5e-3, 10e-3);
      fingers.push_back({x + radius, radius, pick(0.01, 0.06), height + pick(-0.02, 0.02)});
      x += 2.0 * radius + pick(-6e-3, 6e-3);
    }
    for (int frame = 0; frame < 5; ++frame) {
      Samples samples;
      for (const Finger& finger : fingers) finger.press(pick(0.2, 1.5), pick(2e-3, 5e-3), samples);
      leaveOutCovered(fingers, samples);
      std::shuffle(samples.begin(), samples.end(), random);
      samples.resize(samples.size() / 2 + 1);  // pressed here and there
      for (PressureSample& s : samples) s.pressure = static_cast<float>(pick(500.0, 20000.0));
      for (const FocalPoint& point : renderer.render(samples)) {
        worst = std::max(worst, fromSkin(fingers, point.position));
        EXPECT_TRUE(std::isfinite(point.pressure) && std::isfinite(point.intensity));
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 500);
  EXPECT_LE(worst, off_skin);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::skin_disc_test
