#pragma once

#include <Eigen/Core>
#include <vector>

#include "hand/capsule.h"
#include "hand/skin_template.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// One of the many points that cover the surface of a hand, of which the samples of its skin are chosen.
struct SurfacePoint {
  int bone;
  double u;
  Eigen::Vector3d position, normal;
  double spacing;  // m, of samples here

  double area() const;  // m^2, that the point stands for
};

/// Minimum distance of two samples on one side of the skin, m.
/// @param spacing m, of samples in the mean
double sampleDistance(double spacing);

/// Whether a point lies within other skin. Where two capsules share a sphere, the patch belongs to the first.
/// In the bottom of a crease, where a normal runs straight into other skin, a sample would push the clay into
/// the hand: it counts as buried too.
/// @param capsules of the hand, a bone each
bool buried(const SurfacePoint& point, const std::vector<Capsule>& capsules);

/// Points of the hand's surface, bone by bone.
std::vector<SurfacePoint> coverHand(const TrackedHand& hand, double spacing, SkinKind kind);

/// Dart throwing over the cover in a fixed random order, beside samples that are there; points that face away
/// from each other (two fingers side by side) do not compete.
/// @param widest of the distances of samples, m
/// @return indices in the order of the cover
std::vector<int> chooseSamples(const std::vector<SurfacePoint>& cover, double widest,
                               const std::vector<SurfacePoint>& present);

/// Areas of the chosen samples, m^2; what is closer to one that was present before is no one's.
std::vector<double> voronoiAreas(const std::vector<SurfacePoint>& cover, const std::vector<int>& chosen,
                                 double widest, const std::vector<SurfacePoint>& present);

}  // namespace tactile_clay::hand
