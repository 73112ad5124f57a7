#include "hand/inverted_flesh.h"

#include <algorithm>

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3f;

constexpr float healing = 0.3F;   // share of the way back, per step and tetrahedron inside out
constexpr int healing_time = 16;  // steps; flesh that stays inside out for longer is caught
constexpr int trial = 8;          // steps in which the minimum volume has to help caught flesh
constexpr float room = 0.6F;  // volume, over that at rest, with which flesh does not turn inside out again

bool hasRoomAtHome(const NeoHookean& flesh, int tetrahedron, const InvertedFlesh::Home& home) {
  std::array<Vector3f, 4> at;
  const std::array<int, 4> corners = flesh.corners(tetrahedron);
  for (int k = 0; k < 4; ++k) at[k] = home(corners[k]);
  return flesh.volumeShare(tetrahedron, at) > room;
}

}  // namespace

std::array<bool, finger_count> InvertedFlesh::step(const NeoHookean& flesh,
                                                   const std::vector<NodeBinding>& bindings, const Home& home,
                                                   const std::array<bool, body_count>& pressed,
                                                   std::vector<FleshNode>& nodes) {
  std::array<bool, finger_count> inside_out{};
  for (const int t : flesh.inverted(nodes)) {
    steps_.try_emplace(t, 0);
    for (const int n : flesh.corners(t))
      for (const int b : {bindings[n].body, bindings[n].other})
        if (b != palm_body) inside_out[fingerOf(b)] = true;
  }
  for (auto it = steps_.begin(); it != steps_.end();) {
    auto& [t, steps] = *it;
    const float share = flesh.volumeShare(t, nodes);
    const bool caught = steps > healing_time, tried = steps > healing_time + trial;
    const bool right = share > 0.0F, has_room = right && caught && hasRoomAtHome(flesh, t, home);
    if (right && (!caught || (has_room && share > room))) {
      it = steps_.erase(it);
      continue;
    }
    if (right && !has_room)
      steps = healing_time + 1;
    else
      steps = tried ? 1 : steps + 1;
    ++it;
  }
  for (const auto& [t, steps] : steps_) {
    if (steps > healing_time) continue;
    for (const int n : flesh.corners(t)) {
      if (bindings[n].rigid || pressed[bindings[n].body]) continue;
      nodes[n].head<3>() += healing * (home(n) - nodes[n].head<3>());
    }
  }
  return inside_out;
}

bool InvertedFlesh::caught() const {
  return std::any_of(steps_.begin(), steps_.end(), [](const auto& it) { return it.second > healing_time; });
}

}  // namespace tactile_clay::hand
