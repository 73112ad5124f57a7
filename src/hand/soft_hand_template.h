#pragma once

#include <array>
#include <vector>

#include "hand/flesh_mesh.h"
#include "hand/hand_bodies.h"

namespace tactile_clay::hand {

/// How a node hangs on the bones.
struct NodeBinding {
  int body;           // the body that it belongs to
  bool rigid;         // inside the bone: it moves with the body
  int other;          // for flesh: the second nearest body
  float other_share;  // 0 to 0.5
};

/// Flesh of a hand of scale 1 in its rest pose, in metres. Palm and fingers are meshes of their own, which
/// overlap at the knuckles: fingers side by side never grow together, and each has a cell size of its own.
struct SoftHandTemplate {
  TrackedHand rest;
  FleshMesh mesh;                                    // without the tetrahedra inside of bones
  std::vector<NodeBinding> bindings;                 // of the nodes
  std::array<int, 1 + finger_count + 1> part_begin;  // triangles [i, i + 1): palm, then the fingers
};

/// @param finger_cell, palm_cell edges of the lattices' cubes, m
SoftHandTemplate makeSoftHandTemplate(Side side, double finger_cell, double palm_cell);

/// The same flesh for the hand of the other side.
SoftHandTemplate mirroredTemplate(SoftHandTemplate hand);

/// The part whose flesh carries the skin of a region: 0 the palm, 1 to 5 the fingers.
int fleshPart(Joint region);

}  // namespace tactile_clay::hand
