#include "clay/contact/skin_side.h"

#include <algorithm>

namespace tactile_clay::clay {

using Vector = Eigen::Vector3f;

void takeSide(const Skin& skin, std::vector<NearSample>& rest, std::vector<NearSample>& side) {
  const NearSample closest =
      *std::min_element(rest.begin(), rest.end(),
                        [](const NearSample& a, const NearSample& b) { return a.nearest < b.nearest; });
  const Vector facing = skin.normal[closest.sample];
  side.clear();
  std::size_t left = 0;
  for (const NearSample& a : rest) {
    if (skin.normal[a.sample].dot(facing) > Contact::same_side)
      side.push_back(a);
    else
      rest[left++] = a;
  }
  rest.resize(left);
}

SkinPlane planeOf(const Skin& skin, const std::vector<NearSample>& side, const Vector& x, float radius,
                  float dt, std::vector<SampleShare>& shares) {
  const std::size_t first_share = shares.size();
  float total = 0.0f;
  SkinPlane plane;
  for (const NearSample& a : side) {
    const float q = a.nearest / (radius * radius);
    const float weight = std::max((1.0f - q) * (1.0f - q), 1e-6f);
    const Vector motion = dt * skin.velocity[a.sample];
    const Vector& n = skin.normal[a.sample];
    total += weight;
    plane.distance += weight * n.dot(x - skin.position[a.sample]);
    plane.before += weight * n.dot(x - skin.position[a.sample] + motion);
    plane.normal += weight * n;
    plane.drift += weight * motion;
    shares.push_back({a.sample, weight});
  }
  for (std::size_t s = first_share; s < shares.size(); ++s) shares[s].share /= total;
  plane.normal.normalize();
  plane.distance /= total;
  plane.before /= total;
  plane.drift /= total;
  return plane;
}

}  // namespace tactile_clay::clay
