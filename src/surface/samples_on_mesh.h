#pragma once

#include <Eigen/Core>
#include <vector>

#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// Values of samples that lie on a mesh, at its corners.
struct SampleWeights {
  struct Share {
    std::uint32_t sample;
    float weight;  // (1 - (d / reach)^2)^2 of the distance d
  };
  std::vector<std::uint32_t> begin;  // shares of corner i are [begin[i], begin[i + 1])
  std::vector<Share> shares;
};

/// Which samples are near each corner.
/// @param normal of the samples; a sample that faces away from a corner's normal is on another side of the
///   hand and does not count there
/// @param reach m
SampleWeights sampleWeights(const TriangleMesh& mesh, const std::vector<Eigen::Vector3f>& position,
                            const std::vector<Eigen::Vector3f>& normal, float reach);

/// Weighted mean of the samples near each corner; zero if there are none.
std::vector<Eigen::Vector3f> meanAt(const SampleWeights& weights, const std::vector<Eigen::Vector3f>& value);

/// The same if only the samples whose value is not zero are given. Between them and the other samples the
/// value falls to zero.
/// @param full sum of weights at a corner if all samples are given; with a smaller sum, samples are missing
std::vector<float> sparseMeanAt(const SampleWeights& weights, const std::vector<float>& value, float full);

}  // namespace tactile_clay::surface
