#include "hand/bound_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <stdexcept>

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Closest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5), barycentric.
Vector3d closestShare(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0.0, 1.0 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

// Longest edge, m: no point of a triangle is farther than this from a corner of it.
double longestEdge(const FleshMesh& mesh) {
  double longest = 0.0;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, (mesh.nodes[t[k]] - mesh.nodes[t[(k + 1) % 3]]).norm());
  return longest;
}

// Axes of a sample: along the smooth normal, and along the part of an edge that is square to it.
Eigen::Matrix3f frameOf(const Vector3f& normal, const Vector3f& edge) {
  Eigen::Matrix3f frame;
  frame.col(2) = normal;
  const Vector3f flat = edge - edge.dot(normal) * normal;
  frame.col(0) = flat.norm() > 1e-7F ? Vector3f(flat.normalized()) : normal.unitOrthogonal();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

std::vector<Vector3f> smoothNormals(const FleshMesh& mesh, const std::vector<FleshNode>& nodes) {
  std::vector<Vector3f> normals(mesh.nodes.size(), Vector3f::Zero());
  for (const auto& t : mesh.triangles) {
    const Vector3f a = nodes[t[0]].head<3>();
    const Vector3f n = (nodes[t[1]].head<3>() - a).cross(nodes[t[2]].head<3>() - a);
    for (const int k : t) normals[k] += n;
  }
  for (Vector3f& n : normals) n.stableNormalize();
  return normals;
}

// How far the round skin stands out of a flat triangle: half of the way to the tangent planes of its corners
// (Boubekeur & Alexa 2008, Phong tessellation). On a ball the result is the ball. Flesh that is pressed flat
// has flat skin.
Vector3f bulge(const FleshPoint& point, const std::vector<FleshNode>& nodes,
               const std::vector<Vector3f>& normals) {
  const Vector3f x = point.position(nodes);
  Vector3f sum = Vector3f::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vector3f& n = normals[point.node[k]];
    sum -= 0.5F * point.share[k] * n.dot(x - nodes[point.node[k]].head<3>()) * n;
  }
  return sum;
}

}  // namespace

BoundSkin::BoundSkin(const SoftHandTemplate& anatomy, const Skin& skin, double scale) {
  const FleshMesh& mesh = anatomy.mesh;
  std::vector<FleshNode> rest(mesh.nodes.size(), FleshNode::Zero());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) rest[n].head<3>() = mesh.nodes[n].cast<float>();
  const std::vector<Vector3f> normals = smoothNormals(mesh, rest);
  const auto side = static_cast<std::uint8_t>(anatomy.rest.side);
  const double longest = longestEdge(mesh);
  const auto shrink = static_cast<float>(1.0 / scale);
  for (std::size_t i = 0; i < skin.size(); ++i) {
    if (skin.side[i] != side) continue;
    const Vector3d x = skin.position[i].cast<double>() / scale;
    const int part = fleshPart(static_cast<Joint>(skin.region[i]));
    double closest = std::numeric_limits<double>::infinity(), reach = closest;  // m
    int triangle = -1;
    Vector3d share;
    for (int t = anatomy.part_begin[part]; t < anatomy.part_begin[part + 1]; ++t) {
      const auto& n = mesh.triangles[t];
      const Vector3d &a = mesh.nodes[n[0]], &b = mesh.nodes[n[1]], &c = mesh.nodes[n[2]];
      if ((a - x).squaredNorm() > reach * reach) continue;
      if ((b - a).cross(c - a).dot(skin.normal[i].cast<double>()) <= 0.0) continue;
      const Vector3d s = closestShare(x, a, b, c);
      const double d = (s[0] * a + s[1] * b + s[2] * c - x).norm();
      if (d < closest) {
        closest = d;
        reach = d + longest;
        triangle = t;
        share = s;
      }
    }
    if (triangle < 0) throw std::logic_error("soft hand: skin without flesh beneath");
    FleshPoint point;
    point.node = mesh.triangles[triangle];
    point.share = share.cast<float>();
    point.body = static_cast<std::uint8_t>(anatomy.bindings[point.node[0]].body);
    Vector3f normal = Vector3f::Zero();
    Vector3d on = bulge(point, rest, normals).cast<double>();
    for (int k = 0; k < 3; ++k) {
      normal += point.share[k] * normals[point.node[k]];
      on += share[k] * mesh.nodes[point.node[k]];
    }
    const Vector3d ab = mesh.nodes[point.node[1]] - mesh.nodes[point.node[0]];
    const Vector3d ac = mesh.nodes[point.node[2]] - mesh.nodes[point.node[0]];
    const Eigen::Matrix3f frame = frameOf(normal.normalized(), ab.cast<float>());
    Sample sample;
    sample.offset = frame.transpose() * (x - on).cast<float>();
    sample.normal = frame.transpose() * skin.normal[i];
    sample.triangle_area = static_cast<float>(0.5 * ab.cross(ac).norm());
    sample.area = shrink * shrink * skin.area[i];
    sample.pad_distance = shrink * skin.pad_distance[i];
    sample.region = skin.region[i];
    points_.push_back(point);
    samples_.push_back(sample);
  }
}

void BoundSkin::appendTo(Skin& skin, const SoftHandTemplate& anatomy, const std::vector<FleshNode>& nodes,
                         float scale) const {
  const std::vector<Vector3f> normals = smoothNormals(anatomy.mesh, nodes);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const FleshPoint& p = points_[i];
    const Sample& s = samples_[i];
    const Vector3f a = nodes[p.node[0]].head<3>();
    const Vector3f ab = nodes[p.node[1]].head<3>() - a, ac = nodes[p.node[2]].head<3>() - a;
    Vector3f normal =
        p.share[0] * normals[p.node[0]] + p.share[1] * normals[p.node[1]] + p.share[2] * normals[p.node[2]];
    const float size = normal.norm();
    normal = size > 1e-3F ? Vector3f(normal / size) : Vector3f(ab.cross(ac).stableNormalized());
    if (!(normal.squaredNorm() > 0.5F)) normal = Vector3f::UnitZ();
    const Eigen::Matrix3f frame = frameOf(normal, ab);
    const float stretch =
        std::clamp(0.5F * ab.cross(ac).norm() / (scale * scale * s.triangle_area), 0.25F, 4.0F);
    skin.position.push_back(p.position(nodes) + bulge(p, nodes, normals) + scale * (frame * s.offset));
    skin.normal.push_back((frame * s.normal).normalized());
    skin.velocity.push_back(Vector3f::Zero());
    skin.area.push_back(stretch * scale * scale * s.area);
    skin.pad_distance.push_back(scale * s.pad_distance);
    skin.side.push_back(static_cast<std::uint8_t>(anatomy.rest.side));
    skin.region.push_back(s.region);
  }
}

}  // namespace tactile_clay::hand
