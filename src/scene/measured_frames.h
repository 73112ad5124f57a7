#pragma once

#include <vector>

#include "scene/quality.h"
#include "scene/scene.h"
#include "scene/solids.h"

namespace tactile_clay::scene {

/// Time, ms, of a frame of the scene on this computer with each quality, while two balls of the size of fists
/// press into the clay, and none of it sleeps: the first quartile of the frames. A frame is ignored if its
/// threads waited for a processor: while a rig starts, its other nodes need more processor time than later,
/// and load that stays is noticed while the rig runs (clay::LateWatch). If for five seconds there are not
/// enough other frames, these frames count, too. The coarsest quality comes first. The list ends with the
/// first quality that takes longer than `enough`, because a more accurate one would take longer still. Each
/// quality is measured for a quarter of a second, at least three frames, and longer only until three frames
/// count.
/// @param enough ms
std::vector<double> measuredFrames(const Scene& scene, const Solids& solids,
                                   const std::vector<Quality>& qualities, double enough);

/// Two balls of skin that go down into the clay, each from above one of its highest places; one ball if there
/// are no two places that are far enough from each other.
/// @param time s, since they touched the clay
Skin pressingBalls(const Scene& scene, double time);

}  // namespace tactile_clay::scene
