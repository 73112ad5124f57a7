#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "hand/flesh_mesh.h"
#include "lanes/lanes.h"

namespace tactile_clay::hand {

/// Lamé's parameters, Pa.
struct Elasticity {
  double mu, lambda;
  /// @param young Pa
  /// @param poisson 0 to less than 0.5
  static Elasticity of(double young, double poisson) {
    return {young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))};
  }
};

/// Position (x, y, z), m, and mobility (w), m/N, of a node: XPBD's h^2 / m.
using FleshNode = Eigen::Vector4f;

/// Stable Neo-Hookean flesh as XPBD constraints (Macklin et al. 2016; Macklin & Mueller 2021). Their energy
///     mu/2 (|F|^2 - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2,    J = det F, lambda and mu Lame's,
/// is split so that both constraints of a tetrahedron of volume V vanish at rest:
///     C_S = sqrt(|F|^2 + J^2 - 4 J), compliance 1 / (mu V)     C_H = J - 1, compliance 1 / (lambda V).
/// C_S is real by the inequality of means, and zero for rotations only. With the constraints of the paper,
/// |F| and J - 1 - mu / lambda, opposite forces hang in balance at rest and shear is resisted by the change
/// of their directions alone, explicitly, which is not stable at our step. The two are solved together.
///
/// Eight tetrahedra without a common node are solved at a time, in a fixed order: the same bits everywhere.
class NeoHookean {
 public:
  NeoHookean(const FleshMesh& rest, const Elasticity& material);

  /// The rest shape becomes `scale` times the mesh it was made from.
  void rest(double scale);

  /// One Gauss-Seidel pass over the constraints, from multipliers of zero (Macklin et al. 2019, "Small
  /// steps"). A standing load is carried by the material's stiffness where no node's mobility is above 1 /
  /// `stiffness`.
  /// @param squeezed tetrahedra that had little volume when visited, in rising order
  void project(std::vector<FleshNode>& nodes, std::vector<int>& squeezed) const;

  /// Gives tetrahedra back what they lack of `min_volume` of their volume at rest, by Gauss-Seidel sweeps.
  /// The energy above is finite where J = 0, so that a load can turn flesh inside out; real flesh stiffens
  /// before.
  /// @param squeezed as `project` told them
  /// @param reaction N, of each node: what flesh does to those without mobility is added
  void limit(const std::vector<int>& squeezed, std::vector<FleshNode>& nodes,
             std::vector<Eigen::Vector3f>& reaction) const;

  /// Nodes of a tetrahedron, numbered as `project` and `inverted` tell them.
  std::array<int, 4> corners(int tetrahedron) const;
  /// Its volume, of that at rest, with these corners; negative: inside out.
  float volumeShare(int tetrahedron, const std::array<Eigen::Vector3f, 4>& corners) const;
  float volumeShare(int tetrahedron, const std::vector<FleshNode>& nodes) const;

  std::vector<double> stiffness() const;  // N/m, of the flesh at rest against moving one node

  double energy(const std::vector<FleshNode>& nodes) const;              // J, 0 at rest
  std::vector<int> inverted(const std::vector<FleshNode>& nodes) const;  // with det F <= 0, in rising order
  std::size_t size() const { return tetrahedra_.size(); }

 private:
  static constexpr int width = lane_width;
  /// Eight tetrahedra; a lane that is not used holds four nodes that belong to nobody.
  struct Batch {
    std::array<std::array<std::uint32_t, width>, 4> slot;  // of the nodes
    // With B the inverse of the rest edges, as Symmetric: B B^T, 1/m^2, and its inverse, m^2.
    float metric[6][width], edges[6][width];
    float determinant[width];                        // 1/m^3, of B
    float compliance_h[width], compliance_s[width];  // 1/(N m)
  };
  struct Gradients;
  static Gradients gradients(const Batch& batch, const float* nodes);
  static unsigned projectBatch(const Batch& batch, float* nodes);
  static unsigned invertedLanes(const Batch& batch, const float* nodes);
  void appendUsed(std::vector<int>& tetrahedra, std::size_t batch, unsigned lanes) const;
  bool isUnused(const Batch& b, int lane) const {
    return b.slot[0][lane] == slot_size * static_cast<std::uint32_t>(unused_);
  }

  std::vector<std::array<int, 4>> tetrahedra_;
  std::vector<Eigen::Matrix3d> inverse_edges_;  // B at scale 1
  std::vector<double> volume_;                  // m^3 at scale 1
  Elasticity material_;
  double scale_ = 1.0;
  int unused_;  // first of the nodes of lanes that are not used
  std::vector<Batch> batches_;
};

/// Nodes behind those of the mesh that NeoHookean needs; their mobility is zero.
constexpr int unused_flesh_nodes = 4;

}  // namespace tactile_clay::hand
