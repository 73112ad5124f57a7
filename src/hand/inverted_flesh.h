#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <map>
#include <vector>

#include "hand/anatomy.h"
#include "hand/hand_bodies.h"
#include "hand/neo_hookean.h"
#include "hand/soft_hand_template.h"

namespace tactile_clay::hand {

/// Tetrahedra that were turned inside out, as by a pose that no hand can take: they are led back to where
/// their bones would put them. In the fold of a bent finger that would be inside out as well: what stays so,
/// though it had time to heal, is caught, and needs its minimum volume (NeoHookean::limit) until it has room
/// by itself and its bones leave it some. Where they do and it finds none, as in a tangle, it is led back
/// again.
class InvertedFlesh {
 public:
  /// Where its bones would put a node, m.
  using Home = std::function<Eigen::Vector3f(int node)>;

  /// A step: finds what is inside out, and leads it back.
  /// @param bindings of the nodes
  /// @param pressed bodies with a load: flesh is not led back there, which would carry the load beside the
  /// bone
  /// @return the fingers that have flesh inside out
  std::array<bool, finger_count> step(const NeoHookean& flesh, const std::vector<NodeBinding>& bindings,
                                      const Home& home, const std::array<bool, body_count>& pressed,
                                      std::vector<FleshNode>& nodes);

  /// Whether any is caught.
  bool caught() const;
  /// The flesh is placed anew.
  void clear() { steps_.clear(); }

 private:
  std::map<int, int> steps_;  // by tetrahedron, for how many it has been
};

}  // namespace tactile_clay::hand
