#include "hand/neo_hookean.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "hand/flesh_batches.h"
#include "lanes/lane_matrix.h"

namespace tactile_clay::hand {
namespace {

// Of the square of a strain: below the rounding of single precision, and a tetrahedron at rest divides by it.
constexpr float tiny_shear = 1e-9F;
constexpr float small_shear = 1e-3F;
// Of squeezed flesh. What is left of the volume has to last while bones move, until the next step.
constexpr float squeezed_below = 0.95F;  // of the volume at rest, when visited: neighbours may squeeze it yet
constexpr float min_volume = 0.3F;       // of the volume at rest
constexpr float close_to_least = 0.6F;   // of the volume at rest
constexpr float min_compliance = 0.001F;  // of the material's
constexpr int limit_sweeps = 40;          // at most

Eigen::Matrix3d edges(const std::array<int, 4>& t, const std::vector<FleshNode>& nodes) {
  Eigen::Matrix3d e;
  for (int k = 0; k < 3; ++k) e.col(k) = (nodes[t[k + 1]] - nodes[t[0]]).head<3>().cast<double>();
  return e;
}

}  // namespace

NeoHookean::NeoHookean(const FleshMesh& mesh, const Elasticity& material)
    : tetrahedra_(mesh.tetrahedra), material_(material), unused_(static_cast<int>(mesh.nodes.size())) {
  for (const std::array<int, 4>& t : tetrahedra_) {
    Eigen::Matrix3d e;
    for (int k = 0; k < 3; ++k) e.col(k) = mesh.nodes[t[k + 1]] - mesh.nodes[t[0]];
    inverse_edges_.push_back(e.inverse());
    volume_.push_back(volume(mesh, t));
  }
  const std::vector<std::vector<int>> members = fleshBatches(tetrahedra_, width);
  // Tetrahedra in the order of their batches, so that batch b holds those from 8 b on, padded with -1.
  std::vector<std::array<int, 4>> sorted;
  std::vector<Eigen::Matrix3d> sorted_edges;
  std::vector<double> sorted_volume;
  for (const std::vector<int>& batch : members) {
    Batch& b = batches_.emplace_back();
    for (int lane = 0; lane < width; ++lane) {
      const bool used = lane < static_cast<int>(batch.size());
      for (int k = 0; k < 4; ++k)
        b.slot[k][lane] =
            slot_size * static_cast<std::uint32_t>(used ? tetrahedra_[batch[lane]][k] : unused_ + k);
    }
    for (const int i : batch) {
      sorted.push_back(tetrahedra_[i]);
      sorted_edges.push_back(inverse_edges_[i]);
      sorted_volume.push_back(volume_[i]);
    }
  }
  tetrahedra_ = std::move(sorted);
  inverse_edges_ = std::move(sorted_edges);
  volume_ = std::move(sorted_volume);
  rest(1.0);
}

void NeoHookean::rest(double scale) {
  scale_ = scale;
  std::size_t i = 0;
  for (Batch& b : batches_) {
    for (int lane = 0; lane < width; ++lane) {
      if (isUnused(b, lane)) {  // moves nothing: its nodes have no inverse mass
        for (int k = 0; k < 6; ++k) b.metric[k][lane] = b.edges[k][lane] = 0.0F;
        b.determinant[lane] = 1.0F;
        b.compliance_h[lane] = b.compliance_s[lane] = 1.0F;
        continue;
      }
      const Eigen::Matrix3d inverse = inverse_edges_[i] / scale;
      const Eigen::Matrix3d metric = inverse * inverse.transpose();
      const Eigen::Matrix3d edge_products = metric.inverse();
      constexpr int entries[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}};  // as in Symmetric
      for (int k = 0; k < 6; ++k) {
        b.metric[k][lane] = static_cast<float>(metric(entries[k][0], entries[k][1]));
        b.edges[k][lane] = static_cast<float>(edge_products(entries[k][0], entries[k][1]));
      }
      b.determinant[lane] = static_cast<float>(inverse.determinant());
      const double v = volume_[i] * scale * scale * scale;
      b.compliance_h[lane] = static_cast<float>(1.0 / (material_.lambda * v));
      b.compliance_s[lane] = static_cast<float>(1.0 / (material_.mu * v));
      ++i;
    }
  }
}

namespace {

TACTILE_CLAY_INLINE LaneVector cross(const LaneVector& p, const LaneVector& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
TACTILE_CLAY_INLINE LaneVector oppositeOfSum(const Columns& a) {
  return {-(a.x.x + a.y.x + a.z.x), -(a.x.y + a.y.y + a.z.y), -(a.x.z + a.y.z + a.z.z)};
}
TACTILE_CLAY_INLINE Symmetric loadSymmetric(const float (&a)[6][lane_width]) {
  return {load(a[0]), load(a[1]), load(a[2]), load(a[3]), load(a[4]), load(a[5])};
}
/// (p, q, r) L (p, q, r)^T.
TACTILE_CLAY_INLINE Lane quadratic(const Symmetric& l, const Lane& p, const Lane& q, const Lane& r) {
  return p * (l.xx * p + 2.0F * (l.xy * q + l.zx * r)) + q * (l.yy * q + 2.0F * l.yz * r) + l.zz * r * r;
}

}  // namespace

/// det F - 1, the square of C_S, the gradients of det F and of half that square by the nodes, their mobility.
struct NeoHookean::Gradients {
  Lane swelling, shear;
  LaneVector h[4], s[4];
  Lane w[4];
};

TACTILE_CLAY_INLINE NeoHookean::Gradients NeoHookean::gradients(const Batch& b, const float* nodes) {
  Gradients g;
  LaneVector x[4];
  for (int k = 0; k < 4; ++k) x[k] = gather(nodes, b.slot[k].data(), g.w[k]);
  const Columns e{difference(x[1], x[0]), difference(x[2], x[0]), difference(x[3], x[0])};
  // d det F / d edges = det B times the cofactors of the edges
  const Lane determinant = load(b.determinant);
  const Columns h{times(determinant, cross(e.y, e.z)), times(determinant, cross(e.z, e.x)),
                  times(determinant, cross(e.x, e.y))};
  const Lane det = dot(e.x, h.x);
  g.swelling = det - 1.0F;
  // d (|F|^2 / 2) / d edges = edges B B^T
  Columns s = times(e, columnsOf(loadSymmetric(b.metric)));
  const Lane square = dot(e, s), cofactors = det - 2.0F;
  add(s.x, times(cofactors, h.x));
  add(s.y, times(cofactors, h.y));
  add(s.z, times(cofactors, h.z));
  // Near rest the terms cancel to rounding; there C_S^2 is half the square of its half's derivative by F.
  const Symmetric l = loadSymmetric(b.edges);
  const Lane derivative = quadratic(l, s.x.x, s.y.x, s.z.x) + quadratic(l, s.x.y, s.y.y, s.z.y) +
                          quadratic(l, s.x.z, s.y.z, s.z.z);
  const Lane exact = square + det * det - 4.0F * det;
  g.shear = exact < small_shear ? 0.5F * derivative : exact;
  g.h[0] = oppositeOfSum(h);
  g.h[1] = h.x;
  g.h[2] = h.y;
  g.h[3] = h.z;
  g.s[0] = oppositeOfSum(s);
  g.s[1] = s.x;
  g.s[2] = s.y;
  g.s[3] = s.z;
  return g;
}

/// @return the lanes that had little volume
TACTILE_CLAY_MULTIVERSION
unsigned NeoHookean::projectBatch(const Batch& b, float* nodes) {
  const Gradients g = gradients(b, nodes);
  // J W J^T of the two; C_S taken times itself, so that nothing is divided by it where it is zero
  Lane ss{}, sh{}, h2{};
  for (int k = 0; k < 4; ++k) {
    ss += g.w[k] * dot(g.s[k], g.s[k]);
    sh += g.w[k] * dot(g.s[k], g.h[k]);
    h2 += g.w[k] * dot(g.h[k], g.h[k]);
  }
  const Lane shear = g.shear + tiny_shear;
  const Lane a = ss + load(b.compliance_s) * shear, d = h2 + load(b.compliance_h);
  const Lane per_determinant = 1.0F / (a * d - sh * sh);
  const Lane by_s = per_determinant * (sh * g.swelling - d * shear);
  const Lane by_h = per_determinant * (sh * shear - a * g.swelling);
  for (int k = 0; k < 4; ++k) {
    LaneVector way = times(by_s, g.s[k]);
    add(way, times(by_h, g.h[k]));
    float moves[lane_width * slot_size];
    scatter(times(g.w[k], way), moves, slot_size);
    for (int lane = 0; lane < width; ++lane) {
      float* node = nodes + b.slot[k][lane];
      storeSlot(node, slot(node) + slot(moves + slot_size * lane));
    }
  }
  return bits(g.swelling < squeezed_below - 1.0F);
}

void NeoHookean::appendUsed(std::vector<int>& tetrahedra, std::size_t batch, unsigned lanes) const {
  if (lanes == 0) return;
  for (int lane = 0; lane < width; ++lane)
    if ((lanes >> lane & 1U) != 0 && !isUnused(batches_[batch], lane))
      tetrahedra.push_back(static_cast<int>(batch) * width + lane);
}

void NeoHookean::project(std::vector<FleshNode>& nodes, std::vector<int>& squeezed) const {
  squeezed.clear();
  for (std::size_t i = 0; i < batches_.size(); ++i)
    appendUsed(squeezed, i, projectBatch(batches_[i], nodes.front().data()));
}

void NeoHookean::limit(const std::vector<int>& squeezed, std::vector<FleshNode>& nodes,
                       std::vector<Eigen::Vector3f>& reaction) const {
  using Eigen::Vector3f;
  std::vector<int> close;
  bool all_of_them = true;  // or the close ones alone
  for (int sweep = 1; sweep <= limit_sweeps; ++sweep) {
    if (all_of_them) close = squeezed;
    bool all_have_it = true;
    std::size_t kept = 0;
    for (const int t : close) {
      const Batch& b = batches_[t / width];
      const int lane = t % width;
      const std::array<int, 4> n = corners(t);
      const Vector3f o = nodes[n[0]].head<3>();
      const Vector3f p = nodes[n[1]].head<3>() - o, q = nodes[n[2]].head<3>() - o,
                     r = nodes[n[3]].head<3>() - o;
      std::array<Vector3f, 4> g;
      g[1] = b.determinant[lane] * q.cross(r);
      const float volume = p.dot(g[1]);
      if (all_of_them && volume > close_to_least) continue;
      close[kept++] = t;
      const float lacking = min_volume - volume;
      if (!(lacking > 0.0F)) continue;
      g[2] = b.determinant[lane] * r.cross(p);
      g[3] = b.determinant[lane] * p.cross(q);
      g[0] = -(g[1] + g[2] + g[3]);
      float w = 0.0F;
      for (int k = 0; k < 4; ++k) w += nodes[n[k]][3] * g[k].squaredNorm();
      if (!(w > 0.0F)) continue;  // between bones alone
      all_have_it = false;
      w += min_compliance * b.compliance_h[lane];
      for (int k = 0; k < 4; ++k) {
        const Vector3f force = lacking / w * g[k];
        if (nodes[n[k]][3] > 0.0F)
          nodes[n[k]].head<3>() += nodes[n[k]][3] * force;
        else
          reaction[n[k]] += force;
      }
    }
    close.resize(kept);
    if (all_of_them && all_have_it) break;
    all_of_them = all_have_it || sweep % 4 == 0;  // neighbours may have squeezed one that was not close
  }
}

TACTILE_CLAY_MULTIVERSION
unsigned NeoHookean::invertedLanes(const Batch& b, const float* nodes) {
  LaneVector x[4];
  Lane unused;
  for (int k = 0; k < 4; ++k) x[k] = gather(nodes, b.slot[k].data(), unused);
  const LaneVector p = difference(x[1], x[0]), q = difference(x[2], x[0]), r = difference(x[3], x[0]);
  return bits(load(b.determinant) * dot(p, cross(q, r)) <= 0.0F);
}

std::vector<int> NeoHookean::inverted(const std::vector<FleshNode>& nodes) const {
  std::vector<int> found;
  for (std::size_t i = 0; i < batches_.size(); ++i)
    appendUsed(found, i, invertedLanes(batches_[i], nodes.front().data()));
  return found;
}

std::array<int, 4> NeoHookean::corners(int tetrahedron) const {
  std::array<int, 4> n;
  for (int k = 0; k < 4; ++k)
    n[k] = static_cast<int>(batches_[tetrahedron / width].slot[k][tetrahedron % width] / slot_size);
  return n;
}

float NeoHookean::volumeShare(int tetrahedron, const std::array<Eigen::Vector3f, 4>& x) const {
  return batches_[tetrahedron / width].determinant[tetrahedron % width] *
         (x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0]));
}

float NeoHookean::volumeShare(int tetrahedron, const std::vector<FleshNode>& nodes) const {
  const std::array<int, 4> n = corners(tetrahedron);
  std::array<Eigen::Vector3f, 4> x;
  for (int k = 0; k < 4; ++k) x[k] = nodes[n[k]].head<3>();
  return volumeShare(tetrahedron, x);
}

std::vector<double> NeoHookean::stiffness() const {
  std::vector<double> sum(static_cast<std::size_t>(unused_), 0.0);
  for (std::size_t i = 0; i < tetrahedra_.size(); ++i) {
    const Eigen::Matrix3d& b = inverse_edges_[i];  // its rows are the gradients of the nodes 1 to 3
    const double each = (material_.lambda + 2.0 * material_.mu) * volume_[i] * scale_;
    sum[tetrahedra_[i][0]] += each * b.colwise().sum().squaredNorm();
    for (int k = 0; k < 3; ++k) sum[tetrahedra_[i][k + 1]] += each * b.row(k).squaredNorm();
  }
  return sum;
}

double NeoHookean::energy(const std::vector<FleshNode>& nodes) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < tetrahedra_.size(); ++i) {
    const Eigen::Matrix3d f = edges(tetrahedra_[i], nodes) * inverse_edges_[i] / scale_;
    const double v = volume_[i] * scale_ * scale_ * scale_;
    const double j = f.determinant();
    sum += 0.5 * v *
           (material_.mu * (f.squaredNorm() + j * j - 4.0 * j) + material_.lambda * (j - 1.0) * (j - 1.0));
  }
  return sum;
}

}  // namespace tactile_clay::hand
