#include "hand/neo_hookean.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tactile_clay::hand {
namespace {

// Of the square of a strain: below the rounding of single precision, and a tetrahedron at rest divides by it.
constexpr float tiny_shear = 1e-9F;
constexpr float small_shear = 1e-3F;
// Of squeezed flesh. What is left of the volume has to last while bones move, until the next step.
constexpr float squeezed_below = 0.95F;  // of the volume at rest, when visited: neighbours may squeeze it yet
constexpr float least_volume = 0.3F;     // of the volume at rest
constexpr float close_to_least = 0.6F;   // of the volume at rest
constexpr float least_compliance = 0.001F;  // of the material's
constexpr int limit_sweeps = 40;            // at most

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
  // First fit: each tetrahedron goes into the first batch that has room and none of its nodes.
  std::vector<std::vector<int>> members;
  std::size_t first_open = 0;
  for (int i = 0; i < static_cast<int>(tetrahedra_.size()); ++i) {
    const auto fits = [&](const std::vector<int>& batch) {
      if (batch.size() == width) return false;
      for (const int other : batch)
        for (const int n : tetrahedra_[i])
          if (std::count(tetrahedra_[other].begin(), tetrahedra_[other].end(), n) > 0) return false;
      return true;
    };
    while (first_open < members.size() && members[first_open].size() == width) ++first_open;
    const auto batch =
        std::find_if(members.begin() + static_cast<std::ptrdiff_t>(first_open), members.end(), fits);
    if (batch == members.end())
      members.push_back({i});
    else
      batch->push_back(i);
  }
  // Tetrahedra in the order of their batches, so that batch b holds those from 8 b on, padded with -1.
  std::vector<std::array<int, 4>> sorted;
  std::vector<Eigen::Matrix3d> sorted_edges;
  std::vector<double> sorted_volume;
  for (const std::vector<int>& batch : members) {
    Batch& b = batches_.emplace_back();
    for (int lane = 0; lane < width; ++lane) {
      const bool used = lane < static_cast<int>(batch.size());
      for (int k = 0; k < 4; ++k) b.node[k][lane] = used ? tetrahedra_[batch[lane]][k] : unused_ + k;
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
      if (b.node[0][lane] == unused_) {  // moves nothing: its nodes have no inverse mass
        for (int k = 0; k < 6; ++k) b.metric[k][lane] = b.edges[k][lane] = 0.0F;
        b.determinant[lane] = 1.0F;
        b.compliance_h[lane] = b.compliance_s[lane] = 1.0F;
        continue;
      }
      const Eigen::Matrix3d inverse = inverse_edges_[i] / scale;
      const Eigen::Matrix3d metric = inverse * inverse.transpose();
      const Eigen::Matrix3d edge_products = metric.inverse();
      constexpr int entries[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
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

/// det F - 1, the square of C_S, the gradients of det F and of half that square by the nodes, inverse masses.
struct NeoHookean::Gradients {
  Lane swelling, shear;
  std::array<Vector, 4> h, s;
  std::array<Lane, 4> w;
};

NeoHookean::Gradients NeoHookean::gradients(const Batch& b, const std::vector<FleshNode>& nodes) {
  Gradients g;
  std::array<Vector, 4> x;
  for (int k = 0; k < 4; ++k)
    for (int lane = 0; lane < width; ++lane) {
      const FleshNode& n = nodes[b.node[k][lane]];
      x[k].x[lane] = n[0], x[k].y[lane] = n[1], x[k].z[lane] = n[2], g.w[k][lane] = n[3];
    }
  std::array<Vector, 3> e;
  for (int k = 0; k < 3; ++k) {
    e[k].x = x[k + 1].x - x[0].x;
    e[k].y = x[k + 1].y - x[0].y;
    e[k].z = x[k + 1].z - x[0].z;
  }
  // d det F / d edges = det B times the cofactors of the edges
  for (int k = 0; k < 3; ++k) {
    const Vector &p = e[(k + 1) % 3], &q = e[(k + 2) % 3];
    g.h[k + 1].x = b.determinant * (p.y * q.z - p.z * q.y);
    g.h[k + 1].y = b.determinant * (p.z * q.x - p.x * q.z);
    g.h[k + 1].z = b.determinant * (p.x * q.y - p.y * q.x);
  }
  const Lane det = e[0].x * g.h[1].x + e[0].y * g.h[1].y + e[0].z * g.h[1].z;
  g.swelling = det - 1.0F;
  // d (|F|^2 / 2) / d edges = edges B B^T
  const auto& m = b.metric;
  const auto row = [&](Lane Vector::*c) {
    g.s[1].*c = e[0].*c * m[0] + e[1].*c * m[3] + e[2].*c * m[4];
    g.s[2].*c = e[0].*c * m[3] + e[1].*c * m[1] + e[2].*c * m[5];
    g.s[3].*c = e[0].*c * m[4] + e[1].*c * m[5] + e[2].*c * m[2];
  };
  row(&Vector::x), row(&Vector::y), row(&Vector::z);
  Lane square = Lane::Zero();
  for (int k = 0; k < 3; ++k) square += e[k].x * g.s[k + 1].x + e[k].y * g.s[k + 1].y + e[k].z * g.s[k + 1].z;
  const Lane cofactors = det - 2.0F;
  for (int k = 1; k < 4; ++k) {
    g.s[k].x += cofactors * g.h[k].x;
    g.s[k].y += cofactors * g.h[k].y;
    g.s[k].z += cofactors * g.h[k].z;
  }
  // Near rest the terms cancel to rounding; there C_S^2 is half the square of its half's derivative by F.
  Lane derivative = Lane::Zero();
  const auto& l = b.edges;
  const auto along = [&](Lane Vector::*c) {
    const Lane &p = g.s[1].*c, &q = g.s[2].*c, &r = g.s[3].*c;
    derivative +=
        p * (l[0] * p + 2.0F * (l[3] * q + l[4] * r)) + q * (l[1] * q + 2.0F * l[5] * r) + l[2] * r * r;
  };
  along(&Vector::x), along(&Vector::y), along(&Vector::z);
  const Lane exact = square + det * det - 4.0F * det;
  g.shear = (exact < small_shear).select(0.5F * derivative, exact);
  for (auto* part : {&g.h, &g.s}) {
    (*part)[0].x = -((*part)[1].x + (*part)[2].x + (*part)[3].x);
    (*part)[0].y = -((*part)[1].y + (*part)[2].y + (*part)[3].y);
    (*part)[0].z = -((*part)[1].z + (*part)[2].z + (*part)[3].z);
  }
  return g;
}

void NeoHookean::project(std::vector<FleshNode>& nodes, std::vector<int>& squeezed) const {
  squeezed.clear();
  int first = 0;  // lane of the batch
  for (const Batch& b : batches_) {
    const Gradients g = gradients(b, nodes);
    if ((g.swelling < squeezed_below - 1.0F).any())
      for (int lane = 0; lane < width; ++lane) {
        if (g.swelling[lane] < squeezed_below - 1.0F && b.node[0][lane] != unused_)
          squeezed.push_back(first + lane);
      }
    first += width;
    // J W J^T of the two; C_S taken times itself, so that nothing is divided by it where it is zero
    Lane ss = Lane::Zero(), sh = Lane::Zero(), h2 = Lane::Zero();
    for (int k = 0; k < 4; ++k) {
      const Vector &p = g.s[k], &q = g.h[k];
      const Lane& w = g.w[k];
      ss += w * (p.x * p.x + p.y * p.y + p.z * p.z);
      sh += w * (p.x * q.x + p.y * q.y + p.z * q.z);
      h2 += w * (q.x * q.x + q.y * q.y + q.z * q.z);
    }
    const Lane shear = g.shear + tiny_shear;
    const Lane a = ss + b.compliance_s * shear, d = h2 + b.compliance_h;
    const Lane per_determinant = 1.0F / (a * d - sh * sh);
    const Lane by_s = per_determinant * (sh * g.swelling - d * shear);
    const Lane by_h = per_determinant * (sh * shear - a * g.swelling);
    for (int k = 0; k < 4; ++k) {
      const Lane dx = g.w[k] * (by_s * g.s[k].x + by_h * g.h[k].x);
      const Lane dy = g.w[k] * (by_s * g.s[k].y + by_h * g.h[k].y);
      const Lane dz = g.w[k] * (by_s * g.s[k].z + by_h * g.h[k].z);
      for (int lane = 0; lane < width; ++lane) {
        FleshNode& n = nodes[b.node[k][lane]];
        n[0] += dx[lane], n[1] += dy[lane], n[2] += dz[lane];
      }
    }
  }
}

void NeoHookean::limit(const std::vector<int>& squeezed, std::vector<FleshNode>& nodes,
                       std::vector<Eigen::Vector3f>& reaction) const {
  using Eigen::Vector3f;
  std::vector<int> close = squeezed;
  for (int sweep = 0; sweep < limit_sweeps && !close.empty(); ++sweep) {
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
      if (sweep == 0 && volume > close_to_least) continue;  // too far from it for what its neighbours do
      close[kept++] = t;
      const float lacking = least_volume - volume;
      if (!(lacking > 0.0F)) continue;
      g[2] = b.determinant[lane] * r.cross(p);
      g[3] = b.determinant[lane] * p.cross(q);
      g[0] = -(g[1] + g[2] + g[3]);
      float w = 0.0F;
      for (int k = 0; k < 4; ++k) w += nodes[n[k]][3] * g[k].squaredNorm();
      if (!(w > 0.0F)) continue;  // between bones alone
      all_have_it = false;
      w += least_compliance * b.compliance_h[lane];
      for (int k = 0; k < 4; ++k) {
        const Vector3f force = lacking / w * g[k];
        if (nodes[n[k]][3] > 0.0F)
          nodes[n[k]].head<3>() += nodes[n[k]][3] * force;
        else
          reaction[n[k]] += force;
      }
    }
    close.resize(kept);
    if (all_have_it) break;
  }
}

std::array<int, 4> NeoHookean::corners(int tetrahedron) const {
  std::array<int, 4> n;
  for (int k = 0; k < 4; ++k) n[k] = batches_[tetrahedron / width].node[k][tetrahedron % width];
  return n;
}

float NeoHookean::volumeShare(int tetrahedron, const std::vector<FleshNode>& nodes) const {
  const std::array<int, 4> n = corners(tetrahedron);
  const Eigen::Vector3f o = nodes[n[0]].head<3>();
  const Eigen::Vector3f p = nodes[n[1]].head<3>() - o, q = nodes[n[2]].head<3>() - o,
                        r = nodes[n[3]].head<3>() - o;
  return batches_[tetrahedron / width].determinant[tetrahedron % width] * p.dot(q.cross(r));
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

int NeoHookean::inverted(const std::vector<FleshNode>& nodes) const {
  int count = 0;
  for (std::size_t i = 0; i < tetrahedra_.size(); ++i)
    count += (edges(tetrahedra_[i], nodes) * inverse_edges_[i]).determinant() <= 0.0;
  return count;
}

}  // namespace tactile_clay::hand
