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
/// @param normal of the samples; those that face away from a corner's normal are on another side of the hand
/// and do not count
/// @param reach m
SampleWeights sampleWeights(const TriangleMesh& mesh, const std::vector<Eigen::Vector3f>& position,
                            const std::vector<Eigen::Vector3f>& normal, float reach);

/// Weighted mean of the samples near each corner; zero where there are none.
std::vector<Eigen::Vector3f> meanAt(const SampleWeights& weights, const std::vector<Eigen::Vector3f>& value);

/// The same of samples of which only those are given that are not zero: between them and others the value
/// falls to zero.
/// @param full sum of weights where all samples are given, below which a corner lacks some
std::vector<float> sparseMeanAt(const SampleWeights& weights, const std::vector<float>& value, float full);

}  // namespace tactile_clay::surface
