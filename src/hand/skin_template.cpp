#include "hand/skin_template.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <queue>
#include <stdexcept>
#include <string>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/point_grid.h"
#include "hand/skin_cover.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

constexpr double blended_length = 0.8;  // of the joint's radius, on either side of a knuckle

// Dijkstra over the samples, from the pads: the palmar side of the middle of each distal phalanx. The
// neighbourhood grows until it connects the whole skin. This matters only if samples are farther apart than a
// finger is thick.
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

// The bone that a sample shares its normal with, and its weight: a half at the knuckle, 0 from
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

// The same point of the skin in another pose of the hand.
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

// Thumbs at the ends of their motion, and a fist. Tracked thumbs come farther out than the range of our
// tables, -0.35.
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

// Adds samples of the skin that thumb and fingers cover at rest and bare in other poses. `samples` are those
// of the skin at rest.
void addCovered(const TrackedHand& rest, double spacing, const std::vector<SurfacePoint>& samples,
                SkinTemplate& skin) {
  const double distance = sampleDistance(spacing);
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
  const double distance = sampleDistance(spacing);
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
