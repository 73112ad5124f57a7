#include "hand/skin_template.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <queue>
#include <random>
#include <stdexcept>
#include <string>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/point_grid.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

// Random sequential packing covers 0.547 of a plane with disks of half their distance: one sample a spacing^2
// at a distance of sqrt(4 * 0.547 / pi) = 0.835 spacings. On the hand's curved skin and our finite cover it
// is 0.795.
constexpr double poisson_distance = 0.795;
constexpr double pad_spacing = 0.4;  // spacings, of samples on the pads of soft fingers
constexpr int candidates_a_sample = 32;
constexpr double blended_length = 0.8;  // of the joint's radius, on either side of a knuckle

struct SurfacePoint {
  int bone;
  double u;
  Vector3d position, normal;
  double spacing;  // m, of samples here

  double area() const { return spacing * spacing / candidates_a_sample; }  // m^2, that the point stands for
  double sampleDistance() const { return poisson_distance * spacing; }     // m, least
};

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

// Where two capsules share a sphere, the patch belongs to the first. In the bottom of a crease, where a
// normal runs straight into other skin, a sample would push the clay into the hand: it counts as buried too.
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

// Points of the hand's surface.
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

// Dart throwing over the cover in a fixed random order, beside samples that are there; points that face away
// from each other (two fingers side by side) do not compete. Returns indices in the order of the cover, that
// is bone by bone.
std::vector<int> chooseSamples(const std::vector<SurfacePoint>& cover, double widest,
                               const std::vector<SurfacePoint>& present) {
  std::vector<int> order(cover.size());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(20);  // with its own shuffle, for std::shuffle differs between libraries
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  PointGrid grid(widest), taken(widest);
  for (std::size_t i = 0; i < present.size(); ++i) taken.insert(static_cast<int>(i), present[i].position);
  std::vector<int> chosen;
  for (const int candidate : order) {
    const SurfacePoint& point = cover[candidate];
    bool free = true;
    grid.visit(point.position, point.sampleDistance(),
               [&](int other, double) { free = free && cover[other].normal.dot(point.normal) <= 0.0; });
    taken.visit(point.position, point.sampleDistance(),
                [&](int other, double) { free = free && present[other].normal.dot(point.normal) <= 0.0; });
    if (!free) continue;
    grid.insert(candidate, point.position);
    chosen.push_back(candidate);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

// Of the chosen samples; what is closer to one that was present before is no one's.
std::vector<double> voronoiAreas(const std::vector<SurfacePoint>& cover, const std::vector<int>& chosen,
                                 double widest, const std::vector<SurfacePoint>& present) {
  PointGrid grid(widest), taken(widest);
  for (std::size_t i = 0; i < chosen.size(); ++i) grid.insert(static_cast<int>(i), cover[chosen[i]].position);
  for (std::size_t i = 0; i < present.size(); ++i) taken.insert(static_cast<int>(i), present[i].position);
  std::vector<double> areas(chosen.size(), 0.0);
  for (const SurfacePoint& point : cover) {
    int closest = -1;
    double closest_distance = std::numeric_limits<double>::infinity();
    // The set is maximal, so a sample that faces the same way is within the distance.
    grid.visit(point.position, point.sampleDistance(), [&](int sample, double d) {
      if (cover[chosen[sample]].normal.dot(point.normal) <= 0.0 && chosen[sample] != &point - cover.data())
        return;
      if (d < closest_distance) closest = sample, closest_distance = d;
    });
    taken.visit(point.position, point.sampleDistance(), [&](int sample, double d) {
      if (d < closest_distance && present[sample].normal.dot(point.normal) > 0.0) closest = -1;
    });
    if (closest >= 0) areas[closest] += point.area();
  }
  return areas;
}

// Dijkstra over the samples, from the pads: the palmar side of the middle of each distal phalanx. The
// neighbourhood grows until it links the whole skin, which matters only for samples wider apart than a finger
// is thick.
std::vector<double> padDistances(const std::vector<SurfacePoint>& samples, const TrackedHand& hand,
                                 double spacing) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  using Entry = std::pair<double, int>;
  for (double reach = 2.0 * spacing;; reach *= 1.5) {
    PointGrid grid(reach);
    for (std::size_t i = 0; i < samples.size(); ++i) grid.insert(static_cast<int>(i), samples[i].position);
    std::vector<double> distance(samples.size(), infinity);
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto relax = [&](int sample, double d) {
      if (d >= distance[sample]) return;
      distance[sample] = d;
      queue.emplace(d, sample);
    };
    for (const FingerJoints& finger : fingers) {
      const Joint distal = finger[finger.count - 2];
      const JointPose& a = hand.joints[distal];
      const JointPose& b = hand.joints[finger.tip()];
      const Vector3d palmar = a.orientation * -Vector3d::UnitY();
      const Vector3d pad = 0.5 * (a.position + b.position) + 0.5 * (a.radius + b.radius) * palmar;
      grid.visit(pad, reach, [&](int i, double d) {
        if (bones[samples[i].bone].from == distal && samples[i].normal.dot(palmar) > 0.0) relax(i, d);
      });
    }
    while (!queue.empty()) {
      const double d = queue.top().first;
      const int i = queue.top().second;
      queue.pop();
      if (d > distance[i]) continue;
      grid.visit(samples[i].position, reach, [&](int j, double step) {
        if (samples[i].normal.dot(samples[j].normal) > 0.0) relax(j, d + step);
      });
    }
    if (std::all_of(distance.begin(), distance.end(), [](double d) { return d < infinity; })) return distance;
    if (reach > 1.0) throw std::logic_error("skin of the hand: samples are not connected within 1 m");
  }
}

// Which bone a sample shares its normal with, and how much: a half at the knuckle, nothing from
// `blended_length` on.
void blend(const SurfacePoint& point, const TrackedHand& hand, BoundSample& sample) {
  const Capsule capsule = boneCapsule(bones[point.bone], hand);
  for (int other = 0; other < chain_bone_count; ++other) {
    const bool after = follows(point.bone, other);
    if (!after && !follows(other, point.bone)) continue;
    const double from_knuckle = (after ? 1.0 - point.u : point.u) * capsule.length();
    const double reach =
        std::min(blended_length * (after ? capsule.radius_to : capsule.radius_from), 0.5 * capsule.length());
    if (from_knuckle >= reach) continue;
    sample.neighbour = static_cast<std::uint8_t>(other);
    sample.neighbour_weight = static_cast<float>(0.5 * (1.0 - from_knuckle / reach));
  }
}

using RestDirections = decltype(SkinTemplate::rest_direction);

BoundSample boundSample(const SurfacePoint& point, const TrackedHand& hand,
                        const RestDirections& rest_direction, double area, double pad_distance) {
  const auto inBone = [&](int bone) {
    return (boneRotation(bones[bone], rest_direction[bone], hand).transpose() * point.normal)
        .cast<float>()
        .eval();
  };
  BoundSample sample;
  sample.bone = sample.neighbour = static_cast<std::uint8_t>(point.bone);
  sample.neighbour_weight = 0.0F;
  blend(point, hand, sample);
  sample.u = static_cast<float>(point.u);
  sample.normal_in_bone = inBone(sample.bone);
  sample.normal_in_neighbour = inBone(sample.neighbour);
  sample.area = static_cast<float>(area);
  sample.pad_distance = static_cast<float>(pad_distance);
  return sample;
}

// The same point of the skin where the hand is posed otherwise.
SurfacePoint moved(const SurfacePoint& point, const TrackedHand& from, const TrackedHand& to,
                   const RestDirections& rest_direction) {
  const Bone& bone = bones[point.bone];
  const Vector3d normal = boneRotation(bone, rest_direction[point.bone], to) *
                          boneRotation(bone, rest_direction[point.bone], from).transpose() * point.normal;
  const Capsule capsule = boneCapsule(bone, to);
  return {point.bone, point.u, capsule.centre(point.u) + capsule.radius(point.u) * normal, normal,
          point.spacing};
}

HandPose restPose(Side side, double scale) {
  HandPose pose;
  pose.side = side;
  pose.scale = scale;
  const std::array<double, finger_count> spread = {0.0, 0.15, 0.0, -0.12, -0.3};
  for (int finger = 0; finger < finger_count; ++finger) {
    pose.fingers[finger].abduction = spread[finger];
    pose.fingers[finger].flexion =
        finger == 0 ? std::array<double, 3>{0.0, 0.1, 0.4} : std::array<double, 3>{0.4, 0.5, 0.4};
  }
  return pose;
}

// The ends of what thumbs do, and a fist. Tracked thumbs come farther out than the range of our tables,
// -0.35.
std::vector<TrackedHand> baringPoses(double scale) {
  std::vector<HandPose> poses;
  const auto addThumb = [&](double abduction, double cmc, double mp) {
    HandPose& pose = poses.emplace_back(restPose(Side::right, scale));
    pose.fingers[0].abduction = abduction;
    pose.fingers[0].flexion[0] = cmc;
    pose.fingers[0].flexion[1] = mp;
  };
  const double mp_at_rest = restPose(Side::right, scale).fingers[0].flexion[1];
  for (const double abduction : {-0.6, 0.35})
    for (const double cmc : {-0.09, 0.61}) addThumb(abduction, cmc, mp_at_rest);
  addThumb(0.35, -0.09, -0.52);
  HandPose& fist = poses.emplace_back(restPose(Side::right, scale));
  for (int finger = 1; finger < finger_count; ++finger)
    for (int joint = 0; joint < 3; ++joint)
      fist.fingers[finger].flexion[joint] = finger_limits[finger].flexion[joint].y();
  std::vector<TrackedHand> hands;
  std::transform(poses.begin(), poses.end(), std::back_inserter(hands), forwardKinematics);
  return hands;
}

// Adds samples of what thumb and fingers cover at rest and bare elsewhere. `samples` are those of the skin at
// rest.
void addCovered(const TrackedHand& rest, double spacing, const std::vector<SurfacePoint>& samples,
                SkinTemplate& skin) {
  const double distance = poisson_distance * spacing;
  std::vector<Capsule> at_rest;
  for (const Bone& bone : bones) at_rest.push_back(boneCapsule(bone, rest));
  std::vector<SurfacePoint> all = samples;  // at rest
  for (const TrackedHand& hand : baringPoses(skin.scale)) {
    std::vector<SurfacePoint> bare = coverHand(hand, spacing, SkinKind::kinematic), present;
    bare.erase(std::remove_if(bare.begin(), bare.end(),
                              [&](const SurfacePoint& point) {
                                return !buried(moved(point, hand, rest, skin.rest_direction), at_rest);
                              }),
               bare.end());
    for (const SurfacePoint& point : all) present.push_back(moved(point, rest, hand, skin.rest_direction));
    const std::vector<int> chosen = chooseSamples(bare, distance, present);
    const std::vector<double> areas = voronoiAreas(bare, chosen, distance, present);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const SurfacePoint& point = bare[chosen[i]];
      const auto closest =
          std::min_element(present.begin(), present.end(), [&](const auto& a, const auto& b) {
            return (a.position - point.position).squaredNorm() < (b.position - point.position).squaredNorm();
          });
      const double from_pad = skin.samples[closest - present.begin()].pad_distance;
      skin.samples.push_back(boundSample(point, hand, skin.rest_direction, areas[i],
                                         from_pad + (closest->position - point.position).norm()));
      all.push_back(moved(point, hand, rest, skin.rest_direction));
    }
  }
}

}  // namespace

Eigen::Matrix3d boneRotation(const Bone& bone, const Vector3d& rest_direction, const TrackedHand& hand) {
  const Eigen::Quaterniond orientation = hand.joints[bone.frame].orientation.normalized();
  const Vector3d along = hand.joints[bone.to].position - hand.joints[bone.from].position;
  if (along.norm() < 1e-6) return orientation.toRotationMatrix();
  return (orientation * Eigen::Quaterniond::FromTwoVectors(rest_direction, orientation.conjugate() * along))
      .toRotationMatrix();
}

TrackedHand restHand(Side side, double scale) {
  return forwardKinematics(restPose(side, scale));
}

SkinTemplate mirroredTemplate(SkinTemplate skin) {
  skin.side = skin.side == Side::left ? Side::right : Side::left;
  for (BoundSample& sample : skin.samples) {
    sample.normal_in_bone.x() *= -1.0F;
    sample.normal_in_neighbour.x() *= -1.0F;
  }
  for (Vector3d& direction : skin.rest_direction) direction = mirrored(direction);
  return skin;
}

SkinTemplate makeSkinTemplate(Side side, double scale, double spacing, SkinKind kind) {
  if (!(spacing >= 1e-3 && spacing <= 20e-3))
    throw std::invalid_argument("skin sample spacing " + std::to_string(spacing) +
                                " m, expected 0.001 to 0.02 m");
  const TrackedHand hand = restHand(Side::right, scale);
  const std::vector<SurfacePoint> cover = coverHand(hand, spacing, kind);
  const double distance = poisson_distance * spacing;
  const std::vector<int> chosen = chooseSamples(cover, distance, {});
  std::vector<SurfacePoint> points;
  points.reserve(chosen.size());
  for (const int i : chosen) points.push_back(cover[i]);
  const std::vector<double> areas = voronoiAreas(cover, chosen, distance, {});
  const std::vector<double> pad_distances = padDistances(points, hand, spacing);

  SkinTemplate skin;
  skin.scale = scale;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const Vector3d along = hand.joints[bones[i].to].position - hand.joints[bones[i].from].position;
    skin.rest_direction[i] = hand.joints[bones[i].frame].orientation.conjugate() * along.normalized();
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    skin.samples.push_back(boundSample(points[i], hand, skin.rest_direction, areas[i], pad_distances[i]));
  skin.bare_at_rest = skin.samples.size();
  if (kind == SkinKind::kinematic) addCovered(hand, spacing, points, skin);
  return side == Side::left ? mirroredTemplate(std::move(skin)) : skin;
}

}  // namespace tactile_clay::hand
