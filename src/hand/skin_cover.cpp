#include "hand/skin_cover.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <random>

#include "hand/anatomy.h"
#include "hand/hand_shape.h"
#include "hand/point_grid.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

// Random sequential packing covers 0.547 of a plane with disks that have the samples' distance as diameter.
// So one sample per spacing^2 has a distance of sqrt(4 * 0.547 / pi) = 0.835 spacings. On the hand's curved
// skin and our finite cover it is 0.795.
constexpr double poisson_distance = 0.795;
constexpr double pad_spacing = 0.4;  // spacings, of samples on the pads of soft fingers
constexpr int candidates_a_sample = 32;

// An even (Fibonacci) cover of a tapered capsule for samples of a spacing, on the cone and on both caps.
void coverCapsule(const Capsule& capsule, int bone, double spacing, std::vector<SurfacePoint>& points) {
  const double k = std::clamp(capsule.taper(), -1.0, 1.0);
  const double cosine = std::sqrt(1.0 - k * k);
  const double r0 = capsule.radius_from;
  const double r1 = capsule.radius_to;
  const Vector3d axis =
      capsule.length() > 0.0 ? Vector3d((capsule.to - capsule.from).normalized()) : Vector3d::UnitZ();
  const Vector3d side = axis.unitOrthogonal();
  const Vector3d up = axis.cross(side);
  const double golden_angle = M_PI * (3.0 - std::sqrt(5.0));
  const auto add = [&](int i, double u, double axial) {
    const double ring = std::sqrt(std::max(0.0, 1.0 - axial * axial));
    const Vector3d normal =
        axial * axis + ring * (std::cos(i * golden_angle) * side + std::sin(i * golden_angle) * up);
    points.push_back({bone, u, capsule.centre(u) + capsule.radius(u) * normal, normal, spacing});
  };
  const auto count = [&](double area) {
    return static_cast<int>(std::lround(area * candidates_a_sample / (spacing * spacing)));
  };

  const int first_cap = count(2.0 * M_PI * r0 * r0 * (1.0 + k));
  for (int i = 0; i < first_cap; ++i) add(i, 0.0, -1.0 + (1.0 + k) * (i + 0.5) / first_cap);
  const int cone = count(M_PI * (r0 + r1) * cosine * cosine * capsule.length());
  for (int i = 0; i < cone; ++i) {
    const double share = (i + 0.5) / cone;  // of the area between u = 0 and u, which grows with the radius
    const double difference = r1 - r0;
    const double u = std::abs(difference) < 1e-9 * r0
                         ? share
                         : (std::sqrt(r0 * r0 + share * (r1 * r1 - r0 * r0)) - r0) / difference;
    add(i, u, k);
  }
  const int last_cap = count(2.0 * M_PI * r1 * r1 * (1.0 - k));
  for (int i = 0; i < last_cap; ++i) add(i, 1.0, k + (1.0 - k) * (i + 0.5) / last_cap);
}

bool isLastPhalanx(const Bone& bone) {
  return std::any_of(fingers.begin(), fingers.end(),
                     [&](const FingerJoints& finger) { return bone.to == finger.tip(); });
}

// Palmar side and tip of a last phalanx.
bool onPad(const SurfacePoint& point, const TrackedHand& hand) {
  const Bone& bone = bones[point.bone];
  const Vector3d along = (hand.joints[bone.to].position - hand.joints[bone.from].position).normalized();
  const Vector3d palmar = hand.joints[bone.from].orientation * -Vector3d::UnitY();
  return point.normal.dot(along + palmar) > 0.0;
}

}  // namespace

double SurfacePoint::area() const {
  return spacing * spacing / candidates_a_sample;
}

double sampleDistance(double spacing) {
  return poisson_distance * spacing;
}

bool buried(const SurfacePoint& point, const std::vector<Capsule>& capsules) {
  constexpr double touching = 1e-9;  // m
  constexpr double lift = 2e-4;      // m
  for (int other = 0; other < static_cast<int>(capsules.size()); ++other) {
    if (other == point.bone || !capsules[other].mayBeWithin(lift, point.position)) continue;
    const double distance = capsules[other].distance(point.position);
    if (distance < -touching || (distance <= touching && other < point.bone)) return true;
    if (distance < lift && distance > touching &&
        capsules[other].distance(point.position + lift * point.normal) < 0.0)
      return true;
  }
  return false;
}

std::vector<SurfacePoint> coverHand(const TrackedHand& hand, double spacing, SkinKind kind) {
  std::vector<Capsule> capsules;
  capsules.reserve(bones.size());
  for (const Bone& bone : bones) capsules.push_back(boneCapsule(bone, hand));
  std::vector<SurfacePoint> points;
  for (int bone = 0; bone < static_cast<int>(bones.size()); ++bone) {
    const bool padded = kind == SkinKind::soft && isLastPhalanx(bones[bone]);
    std::vector<SurfacePoint> coarse, fine;
    coverCapsule(capsules[bone], bone, spacing, coarse);
    if (padded) coverCapsule(capsules[bone], bone, pad_spacing * spacing, fine);
    std::copy_if(coarse.begin(), coarse.end(), std::back_inserter(points),
                 [&](const SurfacePoint& point) { return !padded || !onPad(point, hand); });
    std::copy_if(fine.begin(), fine.end(), std::back_inserter(points),
                 [&](const SurfacePoint& point) { return onPad(point, hand); });
  }
  points.erase(std::remove_if(points.begin(), points.end(),
                              [&](const SurfacePoint& point) { return buried(point, capsules); }),
               points.end());
  return points;
}

std::vector<int> chooseSamples(const std::vector<SurfacePoint>& cover, double widest,
                               const std::vector<SurfacePoint>& present) {
  std::vector<int> order(cover.size());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(20);  // with its own shuffle, because std::shuffle differs between libraries
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  PointGrid grid(widest), taken(widest);
  for (std::size_t i = 0; i < present.size(); ++i) taken.insert(static_cast<int>(i), present[i].position);
  std::vector<int> chosen;
  for (const int candidate : order) {
    const SurfacePoint& point = cover[candidate];
    bool free = true;
    grid.visit(point.position, sampleDistance(point.spacing),
               [&](int other, double) { free = free && cover[other].normal.dot(point.normal) <= 0.0; });
    taken.visit(point.position, sampleDistance(point.spacing),
                [&](int other, double) { free = free && present[other].normal.dot(point.normal) <= 0.0; });
    if (!free) continue;
    grid.insert(candidate, point.position);
    chosen.push_back(candidate);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::vector<double> voronoiAreas(const std::vector<SurfacePoint>& cover, const std::vector<int>& chosen,
                                 double widest, const std::vector<SurfacePoint>& present) {
  PointGrid grid(widest), taken(widest);
  for (std::size_t i = 0; i < chosen.size(); ++i) grid.insert(static_cast<int>(i), cover[chosen[i]].position);
  for (std::size_t i = 0; i < present.size(); ++i) taken.insert(static_cast<int>(i), present[i].position);
  std::vector<double> areas(chosen.size(), 0.0);
  for (const SurfacePoint& point : cover) {
    int closest = -1;
    double closest_distance = std::numeric_limits<double>::infinity();
    // The set is maximal: a sample that faces the same way is within this distance.
    grid.visit(point.position, sampleDistance(point.spacing), [&](int sample, double d) {
      if (cover[chosen[sample]].normal.dot(point.normal) <= 0.0 && chosen[sample] != &point - cover.data())
        return;
      if (d >= closest_distance) return;
      closest = sample;
      closest_distance = d;
    });
    taken.visit(point.position, sampleDistance(point.spacing), [&](int sample, double d) {
      if (d < closest_distance && present[sample].normal.dot(point.normal) > 0.0) closest = -1;
    });
    if (closest >= 0) areas[closest] += point.area();
  }
  return areas;
}

}  // namespace tactile_clay::hand
