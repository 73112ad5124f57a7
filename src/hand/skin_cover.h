#pragma once

#include <Eigen/Core>
#include <vector>

#include "hand/capsule.h"
#include "hand/skin_template.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// One of the many points that cover the surface of a hand. The samples of its skin are chosen from them.
struct SurfacePoint {
  int bone;
  double u;
  Eigen::Vector3d position, normal;
  double spacing;  // m, mean spacing of samples here

  double area() const;  // m^2, of the skin that the point stands for
};

/// Minimum distance of two samples on one side of the skin, m.
/// @param spacing m, mean spacing of the samples
double sampleDistance(double spacing);

/// Whether a point lies within other skin. If two capsules share a sphere, the patch belongs to the first
/// one. At the bottom of a crease a normal points straight into other skin. A sample there would push the
/// clay into the hand, so it counts as buried, too.
/// @param capsules of the hand, one for each bone
bool buried(const SurfacePoint& point, const std::vector<Capsule>& capsules);

/// Points of the hand's surface, bone by bone.
std::vector<SurfacePoint> coverHand(const TrackedHand& hand, double spacing, SkinKind kind);

/// Dart throwing over the cover in a fixed random order, beside the samples in `present`. Points that face
/// away from each other (two fingers side by side) do not compete.
/// @param widest largest distance of samples, m
/// @return indices in the order of the cover
std::vector<int> chooseSamples(const std::vector<SurfacePoint>& cover, double widest,
                               const std::vector<SurfacePoint>& present);

/// Areas of the chosen samples, m^2. Skin that is closer to a sample in `present` belongs to none of them.
std::vector<double> voronoiAreas(const std::vector<SurfacePoint>& cover, const std::vector<int>& chosen,
                                 double widest, const std::vector<SurfacePoint>& present);

}  // namespace tactile_clay::hand
