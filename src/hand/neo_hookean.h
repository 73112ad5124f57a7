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
  /// @param young Young's modulus, Pa
  /// @param poisson Poisson's ratio, 0 to less than 0.5
  static Elasticity of(double young, double poisson) {
    return {young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))};
  }
};

/// A node of the flesh: position (x, y, z), m, and mobility (w), m/N, which is h^2 / m in XPBD.
using FleshNode = Eigen::Vector4f;

/// Stable Neo-Hookean flesh as XPBD constraints (Macklin et al. 2016; Macklin & Mueller 2021). Their energy
///     mu/2 (|F|^2 - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2,    J = det F, lambda and mu Lame's,
/// is split so that both constraints of a tetrahedron of volume V vanish at rest:
///     C_S = sqrt(|F|^2 + J^2 - 4 J), compliance 1 / (mu V)     C_H = J - 1, compliance 1 / (lambda V).
/// C_S is real by the inequality of means, and zero for rotations only. The constraints of the paper are |F|
/// and J - 1 - mu / lambda. With them, opposite forces are in balance at rest. Then only the change of their
/// directions resists shear, explicitly, which is not stable at our step. The two are solved together.
///
/// Eight tetrahedra without a common node are solved at a time, in a fixed order: the same bits everywhere.
class NeoHookean {
 public:
  NeoHookean(const FleshMesh& rest, const Elasticity& material);

  /// The rest shape becomes `scale` times the mesh of the constructor.
  void rest(double scale);

  /// One Gauss-Seidel pass over the constraints, from multipliers of zero (Macklin et al. 2019, "Small
  /// steps"). A constant load is carried with the material's stiffness if no node's mobility is above 1 /
  /// `stiffness`.
  /// @param squeezed is set to the tetrahedra that had little volume when visited, in rising order
  void project(std::vector<FleshNode>& nodes, std::vector<int>& squeezed) const;

  /// Gives tetrahedra back the volume that they lack to `min_volume` of their volume at rest, by Gauss-Seidel
  /// sweeps. The energy above is finite at J = 0, so a load can turn flesh inside out. Real flesh gets
  /// stiffer before.
  /// @param squeezed as `project` set it
  /// @param reaction N, of each node: adds the force of the flesh on nodes without mobility
  void limit(const std::vector<int>& squeezed, std::vector<FleshNode>& nodes,
             std::vector<Eigen::Vector3f>& reaction) const;

  /// Nodes of a tetrahedron, by its number as in `project` and `inverted`.
  std::array<int, 4> corners(int tetrahedron) const;
  /// Volume of a tetrahedron with these corners, over its volume at rest; negative: inside out.
  float volumeShare(int tetrahedron, const std::array<Eigen::Vector3f, 4>& corners) const;
  float volumeShare(int tetrahedron, const std::vector<FleshNode>& nodes) const;

  std::vector<double> stiffness() const;  // N/m, of the flesh at rest against moving one node

  double energy(const std::vector<FleshNode>& nodes) const;              // J, 0 at rest
  std::vector<int> inverted(const std::vector<FleshNode>& nodes) const;  // with det F <= 0, in rising order
  std::size_t size() const { return tetrahedra_.size(); }

 private:
  static constexpr int width = lane_width;
  /// Eight tetrahedra. An unused lane has four nodes that belong to no tetrahedron.
  struct Batch {
    std::array<std::array<std::uint32_t, width>, 4> slot;  // slots of the nodes
    // B is the inverse of the rest edges: B B^T, 1/m^2, and its inverse, m^2, each as Symmetric.
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
  int unused_;  // index of the first node of unused lanes
  std::vector<Batch> batches_;
};

/// Number of nodes that NeoHookean needs behind those of the mesh; their mobility is zero.
constexpr int unused_flesh_nodes = 4;

}  // namespace tactile_clay::hand
