#pragma once

#include <vector>

#include "hand/flesh_mesh.h"
#include "hand/neo_hookean.h"

/// A finger of two capsules, to be filled with flesh.
namespace tactile_clay::hand {

inline std::vector<FleshNode> nodesOf(const FleshMesh& mesh, float mobility) {
  std::vector<FleshNode> nodes(mesh.nodes.size() + unused_flesh_nodes, FleshNode::Zero());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) nodes[n] << mesh.nodes[n].cast<float>(), mobility;
  return nodes;
}

inline const std::vector<Capsule>& bentFinger() {
  static const std::vector<Capsule> capsules = {{{0, 0, 0}, {0, 0, -0.04}, 0.010, 0.008},
                                                {{0, 0, -0.04}, {0, -0.02, -0.06}, 0.008, 0.0065}};
  return capsules;
}

}  // namespace tactile_clay::hand
