#include "hand/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tactile_clay::hand::calibration_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d poseOf(const Vector3d& position, const Vector3d& angles) {
  return Eigen::Translation3d(position) * Eigen::AngleAxisd(angles.z(), Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angles.y(), Vector3d::UnitY()) * Eigen::AngleAxisd(angles.x(), Vector3d::UnitX());
}

const std::vector<Vector3d> marks = {{0.1, 0.1, 0.0}, {0.1, -0.1, 0.0}, {-0.08, 0.0, 0.02}};

std::vector<Vector3d> seenFrom(const Isometry3d& tracker, std::vector<Vector3d> points) {
  for (Vector3d& point : points) point = tracker.inverse() * point;
  return points;
}

double angleBetween(const Isometry3d& a, const Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

TEST(FitRigid, FindsThePoseExactly) {
  for (const Vector3d& angles : {Vector3d(0.0, 0.0, 0.0), Vector3d(0.1, -0.2, 3.0), Vector3d(-3.1, 1.2, -1.0),
                                 Vector3d(M_PI, 0.0, 0.0)}) {
    const Isometry3d truth = poseOf({0.05, -0.02, -0.09}, angles);
    const RigidFit fit = fitRigid(seenFrom(truth, marks), marks);
    EXPECT_TRUE(fit.pose.isApprox(truth, 1e-12));
    EXPECT_LT(fit.worst, 1e-12);
    EXPECT_NEAR(fit.pose.linear().determinant(), 1.0, 1e-12);
  }
}

// If a tracker sees everything 3 % too large, no scale corrects it: the remaining error is reported.
TEST(FitRigid, HasNoScale) {
  std::vector<Vector3d> grown = marks;
  for (Vector3d& point : grown) point *= 1.03;
  const RigidFit fit = fitRigid(grown, marks);
  EXPECT_NEAR((fit.pose.linear() * Vector3d::UnitX()).norm(), 1.0, 1e-12);
  EXPECT_GT(fit.rms, 0.002);
}

// Least squares: if touches are 1 mm off (normal, each coordinate), the middle of the three marks is found to
// 1 mm / sqrt(3) per coordinate, which is 1 mm as a root mean square.
TEST(FitRigid, ErrorsOfTouchAverageOut) {
  std::mt19937 random(7);
  std::normal_distribution<double> millimetre(0.0, 0.001);
  const Isometry3d truth = poseOf({0.0, 0.0, -0.09}, {0.02, 0.01, 0.3});
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& mark : marks) middle += mark / 3.0;
  double sum = 0.0, turned = 0.0;
  constexpr int tries = 400;
  for (int i = 0; i < tries; ++i) {
    auto touched = seenFrom(truth, marks);
    for (Vector3d& point : touched)
      point += Vector3d(millimetre(random), millimetre(random), millimetre(random));
    const RigidFit fit = fitRigid(touched, marks);
    sum += (fit.pose * truth.inverse() * middle - middle).squaredNorm();
    turned = std::max(turned, angleBetween(fit.pose, truth));
    EXPECT_LT(fit.worst, 0.005);
  }
  EXPECT_NEAR(std::sqrt(sum / tries), 0.001, 0.0001);
  EXPECT_LT(turned, 0.05);
}

TEST(FitRigid, SaysWhatIsWrong) {
  const auto expectFault = [](const std::vector<Vector3d>& from, const std::vector<Vector3d>& to,
                              const char* words) {
    try {
      fitRigid(from, to);
      ADD_FAILURE() << words;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  expectFault({marks[0], marks[1]}, {marks[0], marks[1]}, "3 at least");
  expectFault(marks, {marks[0], marks[1]}, "as many of each");
  expectFault({}, {}, "3 at least");
  const std::vector<Vector3d> line = {{0.0, 0.0, 0.0}, {0.1, 0.1, 0.0}, {0.2, 0.2001, 0.0}};
  expectFault(line, marks, "touched points lie on one line");
  // 20 cm long and 3 cm wide: touched to 2 mm, it would be tilted by several degrees.
  expectFault({{0.0, 0.0, 0.0}, {0.2, 0.0, 0.0}, {0.1, 0.03, 0.0}}, marks, "touched points lie on one line");
  expectFault(marks, line, "marked points lie on one line");
  expectFault({marks[0], marks[0], marks[0]}, marks, "touched points lie on one line");
  auto nan = marks;
  nan[1].y() = std::numeric_limits<double>::quiet_NaN();
  expectFault(nan, marks, "touched point is not finite");
}

TEST(TouchDetector, FindsEachPlaceOnceAndItsMean) {
  TouchDetector detector;
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0.0, 0.0003);
  std::vector<Vector3d> found;
  double time = 0.0;
  const auto rest = [&](const Vector3d& at, double seconds) {
    for (const double end = time + seconds; time < end; time += 0.01)
      if (const auto place = detector.add(time, at + Vector3d(noise(random), noise(random), noise(random))))
        found.push_back(*place);
  };
  const auto move = [&](const Vector3d& from, const Vector3d& to) {  // 0.1 m/s
    const double seconds = (to - from).norm() / 0.1;
    for (double t = 0.0; t < seconds; t += 0.01, time += 0.01)
      if (detector.add(time, from + t / seconds * (to - from))) ADD_FAILURE() << "a moving finger touches";
  };
  rest(marks[0], 3.0);
  move(marks[0], marks[1]);
  rest(marks[1], 0.5);  // too short
  detector.lose();
  rest(marks[1], 1.5);
  move(marks[1], marks[2]);
  rest(marks[2], 1.0);
  ASSERT_EQ(found.size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_LT((found[i] - marks[i]).norm(), 0.0005);
}

TEST(TrackerPose, IsWrittenAsTheRigReadsIt) {
  for (const Vector3d& angles :
       {Vector3d(0.1, -0.2, 3.0), Vector3d(-3.0, 1.5, -1.0), Vector3d(0.0, M_PI / 2, 0.4)}) {
    const Isometry3d pose = poseOf({0.05, -0.02, -0.09}, angles);
    EXPECT_LT(angleBetween(poseOf(pose.translation(), rollPitchYaw(pose.linear())), pose), 1e-7);
  }
  EXPECT_EQ(trackerPoseLine(poseOf({0.05, -0.02, -0.09}, {0.1, -0.2, 1.5})),
            "tracker_pose: [0.05000, -0.02000, -0.09000, 0.10000, -0.20000, 1.50000]");
}

TEST(TrackerPose, ReplacesItsLineOnly) {
  const Isometry3d pose = poseOf({1.0, 2.0, 3.0}, Vector3d::Zero());
  const std::string line = "tracker_pose: [1.00000, 2.00000, 3.00000, 0.00000, 0.00000, 0.00000]\n";
  EXPECT_EQ(
      withTrackerPose("# tracker_pose: of old\ntracker_pose: [0, 0, 0, 0, 0, 0]\narray_pose: [1]\n", pose),
      "# tracker_pose: of old\n" + line + "array_pose: [1]\n");
  EXPECT_EQ(withTrackerPose("array_pose: [1]", pose), "array_pose: [1]\n" + line);
  EXPECT_EQ(withTrackerPose("", pose), line);
}

}  // namespace
}  // namespace tactile_clay::hand::calibration_test
