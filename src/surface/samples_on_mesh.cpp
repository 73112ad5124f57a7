#include "surface/samples_on_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tactile_clay::surface {

SampleWeights sampleWeights(const TriangleMesh& mesh, const std::vector<Eigen::Vector3f>& position,
                            const std::vector<Eigen::Vector3f>& normal, float reach) {
  // Samples in the order of x: those within reach of a corner are one run.
  std::vector<std::uint32_t> order;
  for (std::uint32_t s = 0; s < position.size(); ++s)
    if (position[s].allFinite()) order.push_back(s);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return position[a].x() != position[b].x() ? position[a].x() < position[b].x() : a < b;
  });
  SampleWeights weights;
  weights.begin.push_back(0);
  const float per_reach2 = 1.0f / (reach * reach);
  for (std::size_t c = 0; c < mesh.position.size(); ++c) {
    const Eigen::Vector3f& at = mesh.position[c];
    const auto first = std::lower_bound(order.begin(), order.end(), at.x() - reach,
                                        [&](std::uint32_t s, float x) { return position[s].x() < x; });
    for (auto s = first; s != order.end() && position[*s].x() <= at.x() + reach; ++s) {
      const Eigen::Vector3f d = position[*s] - at;
      const float rest = 1.0f - d.squaredNorm() * per_reach2;
      if (rest > 0.0f && normal[*s].dot(mesh.normal[c]) > 0.0f) weights.shares.push_back({*s, rest * rest});
    }
    weights.begin.push_back(static_cast<std::uint32_t>(weights.shares.size()));
  }
  return weights;
}

std::vector<Eigen::Vector3f> meanAt(const SampleWeights& weights, const std::vector<Eigen::Vector3f>& value) {
  std::vector<Eigen::Vector3f> means(weights.begin.size() - 1, Eigen::Vector3f::Zero());
  for (std::size_t c = 0; c < means.size(); ++c) {
    float sum = 0.0f;
    for (std::uint32_t k = weights.begin[c]; k < weights.begin[c + 1]; ++k) {
      means[c] += weights.shares[k].weight * value[weights.shares[k].sample];
      sum += weights.shares[k].weight;
    }
    if (sum > 0.0f) means[c] /= sum;
  }
  return means;
}

std::vector<float> sparseMeanAt(const SampleWeights& weights, const std::vector<float>& value, float full) {
  std::vector<float> means(weights.begin.size() - 1, 0.0f);
  for (std::size_t c = 0; c < means.size(); ++c) {
    float sum = 0.0f;
    for (std::uint32_t k = weights.begin[c]; k < weights.begin[c + 1]; ++k) {
      means[c] += weights.shares[k].weight * value[weights.shares[k].sample];
      sum += weights.shares[k].weight;
    }
    means[c] /= std::max(sum, full);
  }
  return means;
}

}  // namespace tactile_clay::surface
