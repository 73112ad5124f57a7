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

/// Moves tetrahedra that were turned inside out, as by a pose that no hand can take, back to where their
/// bones would put them. In the fold of a bent finger that place can be inside out as well. So a tetrahedron
/// that stays inside out for `healing_time` steps counts as caught. It is then not moved, but gets its
/// minimum volume (NeoHookean::limit), until it has room by itself and its bones leave it room. It is moved
/// back again if, after `trial` steps, it is still inside out, or its bones leave it room and it still has
/// none, as in a tangle.
class InvertedFlesh {
 public:
  /// Place of a node by the poses of its bones, m.
  using Home = std::function<Eigen::Vector3f(int node)>;

  /// A step: finds tetrahedra that are inside out, and moves them back.
  /// @param bindings of the nodes
  /// @param pressed bodies with a load. Their flesh is not moved back, because this would carry the load past
  /// the bone
  /// @return the fingers that have flesh inside out
  std::array<bool, finger_count> step(const NeoHookean& flesh, const std::vector<NodeBinding>& bindings,
                                      const Home& home, const std::array<bool, body_count>& pressed,
                                      std::vector<FleshNode>& nodes);

  /// Whether a tetrahedron is caught.
  bool caught() const;
  /// To be called when the flesh is placed anew.
  void clear() { steps_.clear(); }

 private:
  std::map<int, int> steps_;  // number of steps so far, by tetrahedron
};

}  // namespace tactile_clay::hand
