#include "clay/contact/skin_side.h"

#include <algorithm>

namespace tactile_clay::clay {

using Vector = Eigen::Vector3f;

void takeSide(const Ghosts& ghosts, std::vector<NearGhost>& rest, std::vector<NearGhost>& side) {
  const NearGhost closest = *std::min_element(
      rest.begin(), rest.end(), [](const NearGhost& a, const NearGhost& b) { return a.nearest < b.nearest; });
  const Vector facing = ghosts.normal[closest.ghost];
  side.clear();
  std::size_t left = 0;
  for (const NearGhost& a : rest) {
    if (ghosts.normal[a.ghost].dot(facing) > Contact::same_side)
      side.push_back(a);
    else
      rest[left++] = a;
  }
  rest.resize(left);
}

SkinPlane planeOf(const Ghosts& ghosts, const std::vector<NearGhost>& side, const Vector& x, float radius,
                  float dt, std::vector<GhostShare>& shares) {
  const std::size_t first_share = shares.size();
  float total = 0.0f;
  SkinPlane plane;
  for (const NearGhost& a : side) {
    const float q = a.nearest / (radius * radius);
    const float weight = std::max((1.0f - q) * (1.0f - q), 1e-6f);
    const Vector motion = dt * ghosts.velocity[a.ghost];
    const Vector& n = ghosts.normal[a.ghost];
    total += weight;
    plane.distance += weight * n.dot(x - ghosts.position[a.ghost]);
    plane.before += weight * n.dot(x - ghosts.position[a.ghost] + motion);
    plane.normal += weight * n;
    plane.drift += weight * motion;
    shares.push_back({a.ghost, weight});
  }
  for (std::size_t s = first_share; s < shares.size(); ++s) shares[s].share /= total;
  plane.normal.normalize();
  plane.distance /= total;
  plane.before /= total;
  plane.drift /= total;
  return plane;
}

}  // namespace tactile_clay::clay
