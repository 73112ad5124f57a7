#pragma once

#include <vector>

#include "scene/quality.h"
#include "scene/scene.h"
#include "scene/solids.h"

namespace tactile_clay::scene {

/// ms that a frame of the scene takes this computer with each quality, while two balls of the size of fists
/// press into the clay, and none of it sleeps: what the fastest quarter of the frames stays under. Frames
/// whose threads waited for a processor do not count: while a rig starts, its other nodes need more than they
/// will later, and what stays is found out while it runs (clay::LateWatch). If there are none but such for
/// five seconds, they count. The coarsest quality comes first; the list ends with the first that takes longer
/// than `enough`, for a more accurate one does as well. Of one quality a quarter of a second is measured,
/// three frames at least, and more only to find such that count.
/// @param enough ms
std::vector<double> measuredFrames(const Scene& scene, const Solids& solids,
                                   const std::vector<Quality>& qualities, double enough);

/// Two balls of skin that go down into the clay, each from above one of its highest places; one where it has
/// no two that are far enough from each other.
/// @param time s, since they touched it
Skin pressingBalls(const Scene& scene, double time);

}  // namespace tactile_clay::scene
