#include "clay/solid.h"

#include <gtest/gtest.h>

#include <random>

namespace tactile_clay::clay::solid_test {
namespace {

Solid solidOf(Solid::Shape shape, const Eigen::Vector3d& size) {
  Solid solid;
  solid.shape = shape;
  solid.size = size;
  return solid;
}

const Solid box = solidOf(Solid::Shape::box, {0.03, 0.02, 0.01});
const Solid cylinder = solidOf(Solid::Shape::cylinder, {0.02, 0.03, 0.0});
const Solid sphere = solidOf(Solid::Shape::sphere, {0.025, 0.0, 0.0});

bool inside(const Solid& s, const Eigen::Vector3d& p) {
  switch (s.shape) {
    case Solid::Shape::box:
      return (p.cwiseAbs() - s.size).maxCoeff() < 0.0;
    case Solid::Shape::cylinder:
      return p.head<2>().norm() < s.size.x() && std::abs(p.z()) < s.size.y();
    case Solid::Shape::sphere:
      return p.norm() < s.size.x();
    case Solid::Shape::mesh:  // has tests of its own
      break;
  }
  return false;
}

/// Points of the surface, no more than `pitch` apart.
std::vector<Eigen::Vector3d> samples(const Solid& s, double pitch) {
  std::vector<Eigen::Vector3d> points;
  const auto steps = [pitch](double length) { return static_cast<int>(std::ceil(length / pitch)); };
  if (s.shape == Solid::Shape::box) {
    for (int axis = 0; axis < 3; ++axis) {
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      const int na = steps(2.0 * s.size[a]), nb = steps(2.0 * s.size[b]);
      for (int i = 0; i <= na; ++i) {
        for (int j = 0; j <= nb; ++j) {
          for (const double side : {-1.0, 1.0}) {
            Eigen::Vector3d p;
            p[axis] = side * s.size[axis];
            p[a] = s.size[a] * (2.0 * i / na - 1.0);
            p[b] = s.size[b] * (2.0 * j / nb - 1.0);
            points.push_back(p);
          }
        }
      }
    }
    return points;
  }
  const double radius = s.size.x();
  const int around = steps(2.0 * M_PI * radius);
  for (int k = 0; k < around; ++k) {
    const double angle = 2.0 * M_PI * k / around;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    if (s.shape == Solid::Shape::sphere) {
      const int n = steps(M_PI * radius);
      for (int i = 0; i <= n; ++i) {
        const double polar = M_PI * i / n;
        points.push_back(radius * (std::sin(polar) * out + std::cos(polar) * Eigen::Vector3d::UnitZ()));
      }
      continue;
    }
    const double half = s.size.y();
    for (int i = 0, n = steps(2.0 * half); i <= n; ++i) {
      points.push_back(radius * out + half * (2.0 * i / n - 1.0) * Eigen::Vector3d::UnitZ());
    }
    for (int i = 0, n = steps(radius); i <= n; ++i) {
      for (const double side : {-half, half}) {
        points.push_back(radius * i / n * out + side * Eigen::Vector3d::UnitZ());
      }
    }
  }
  return points;
}

class SolidSurface : public ::testing::TestWithParam<Solid> {};

TEST_P(SolidSurface, DistanceIsThatToTheNearestSample) {
  constexpr double pitch = 0.0008;
  const auto points = samples(GetParam(), pitch);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> along(-0.05, 0.05);
  for (int k = 0; k < 150; ++k) {
    const Eigen::Vector3d p(along(random), along(random), along(random));
    double nearest = INFINITY;
    for (const Eigen::Vector3d& s : points) nearest = std::min(nearest, (p - s).norm());
    const SurfacePoint found = surface(GetParam(), p);
    EXPECT_EQ(found.distance < 0.0, inside(GetParam(), p)) << p.transpose();
    EXPECT_LE(std::abs(found.distance), nearest + 1e-12) << p.transpose();
    EXPECT_NEAR(std::abs(found.distance), nearest, pitch) << p.transpose();
  }
}

TEST_P(SolidSurface, NormalIsTheGradientAndLeadsToTheSurface) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> along(-0.05, 0.05);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d p(along(random), along(random), along(random));
    const SurfacePoint found = surface(GetParam(), p);
    EXPECT_NEAR(found.normal.norm(), 1.0, 1e-12);
    // outward: a step along it gains its length in distance
    EXPECT_NEAR(surface(GetParam(), p + 1e-6 * found.normal).distance - found.distance, 1e-6, 1e-9);
    EXPECT_NEAR(surface(GetParam(), p - found.distance * found.normal).distance, 0.0, 1e-12);
  }
}

TEST_P(SolidSurface, MedialPointsHaveAWayOut) {
  const SurfacePoint centre = surface(GetParam(), Eigen::Vector3d::Zero());
  EXPECT_LT(centre.distance, 0.0);
  EXPECT_NEAR(centre.normal.norm(), 1.0, 1e-12);
  EXPECT_NEAR(surface(GetParam(), -centre.distance * centre.normal).distance, 0.0, 1e-12);
}

std::string nameOf(const ::testing::TestParamInfo<Solid>& tested) {
  return tested.param.shape == Solid::Shape::box        ? "Box"
         : tested.param.shape == Solid::Shape::cylinder ? "Cylinder"
                                                        : "Sphere";
}

INSTANTIATE_TEST_SUITE_P(Shapes, SolidSurface, ::testing::Values(box, cylinder, sphere), nameOf);

TEST(PoseAfter, IsTheExponentialOfTheVelocities) {
  Solid solid = box;
  solid.pose = Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX());
  solid.linear_velocity = {0.5, -1.0, 2.0};
  solid.angular_velocity = {1.0, 2.0, -3.0};
  const double t = 0.03, step = 1e-6;
  EXPECT_TRUE(poseAfter(solid, 0.0).isApprox(solid.pose, 1e-14));
  const Eigen::Isometry3d pose = poseAfter(solid, t), next = poseAfter(solid, t + step);
  EXPECT_TRUE(((next.translation() - pose.translation()) / step).isApprox(solid.linear_velocity, 1e-6));
  const Eigen::Matrix3d rate = (next.linear() - pose.linear()) / step * pose.linear().transpose();
  const Eigen::Vector3d spin(rate(2, 1), rate(0, 2), rate(1, 0));
  EXPECT_TRUE(spin.isApprox(solid.angular_velocity, 1e-5));
  EXPECT_NEAR((pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-13);
  // a full turn comes back
  solid.angular_velocity = {0.0, 0.0, 2.0 * M_PI};
  EXPECT_TRUE(poseAfter(solid, 1.0).linear().isApprox(solid.pose.linear(), 1e-12));
}

}  // namespace
}  // namespace tactile_clay::clay::solid_test
