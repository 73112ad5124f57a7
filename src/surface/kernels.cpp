#include "surface/kernels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tactile_clay::surface {
namespace {

constexpr float radius = 2.2f;      // spacings, R
constexpr float floor_full = 0.2f;  // b of a particle with all its neighbours
// b of a particle that is alone: its field is 1/2 on a ball of one spacing^3, (1 - q)^3 = 1/2 at
// q = (3 / (4 pi))^(2/3) / (b R^2).
constexpr float floor_alone = 0.3853f;
constexpr float smoothing = 0.5f;  // by which a centre is moved towards the mean of its neighbours

double checked(double spacing) {
  if (!(spacing >= 0.001 && spacing <= 0.02))
    throw std::invalid_argument("spacing " + std::to_string(spacing) + " m: expected 0.001 to 0.02");
  return spacing;
}

/// Sums over the neighbours of a particle, with their kernel weights.
struct Moments {
  float w = 1.0f;  // the particle's own
  Eigen::Vector3f x = Eigen::Vector3f::Zero();
  float xx = 0.0f, xy = 0.0f, xz = 0.0f, yy = 0.0f, yz = 0.0f, zz = 0.0f;
};

TACTILE_CLAY_MULTIVERSION
void addNeighbours(const clay::NeighbourPairs pairs, std::size_t i, float per_radius2, Moments& m) {
  Lane w{}, wx{}, wy{}, wz{}, xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
  for (std::uint32_t pair = pairs.begin[i]; pair < pairs.end[i]; pair += lane_width) {
    const LaneVector d = loadVector(pairs.x, pairs.y, pairs.z, pair);
    const Lane a = positive(1.0f - dot(d, d) * per_radius2);
    const Lane k = a * a * a;
    const LaneVector kd = times(k, d);
    w += k;
    wx += kd.x;
    wy += kd.y;
    wz += kd.z;
    xx += kd.x * d.x;
    xy += kd.x * d.y;
    xz += kd.x * d.z;
    yy += kd.y * d.y;
    yz += kd.y * d.z;
    zz += kd.z * d.z;
  }
  m.w += sum(w);
  m.x = -Eigen::Vector3f(sum(wx), sum(wy), sum(wz));  // offsets point from the neighbour to the particle
  m.xx = sum(xx);
  m.xy = sum(xy);
  m.xz = sum(xz);
  m.yy = sum(yy);
  m.yz = sum(yz);
  m.zz = sum(zz);
}

/// Sum of the kernel of that shape over the particle itself and its neighbours.
TACTILE_CLAY_MULTIVERSION
float kernelSum(const clay::NeighbourPairs pairs, std::size_t i, const float (&s)[6]) {
  Lane w{};
  for (std::uint32_t pair = pairs.begin[i]; pair < pairs.end[i]; pair += lane_width) {
    const LaneVector d = loadVector(pairs.x, pairs.y, pairs.z, pair);
    const Lane q = d.x * (s[0] * d.x + 2.0f * (s[1] * d.y + s[2] * d.z)) +
                   d.y * (s[3] * d.y + 2.0f * s[4] * d.z) + s[5] * d.z * d.z;
    const Lane a = positive(1.0f - q);
    w += a * a * a;
  }
  return 1.0f + sum(w);
}

}  // namespace

Kernels::Kernels(double spacing)
    : radius_(radius * static_cast<float>(checked(spacing))),
      lattice_sum_(0.0f),
      lattice_var_(0.0f),
      near_(radius_) {
  const int reach = static_cast<int>(std::ceil(radius));
  const float h = static_cast<float>(spacing);
  for (int a = -reach; a <= reach; ++a) {
    for (int b = -reach; b <= reach; ++b) {
      for (int c = -reach; c <= reach; ++c) {
        const float rest =
            std::max(0.0f, 1.0f - static_cast<float>(a * a + b * b + c * c) / (radius * radius));
        const float k = rest * rest * rest;
        lattice_sum_ += k;
        lattice_var_ += k * static_cast<float>(a * a) * h * h;
      }
    }
  }
  lattice_var_ /= lattice_sum_;
}

std::vector<EllipsoidKernel> Kernels::update(const clay::VectorField& position) {
  near_.build(position);
  std::vector<EllipsoidKernel> kernels(position.size());
  const float per_radius2 = 1.0f / (radius_ * radius_);
  const float alone = 1.0f / lattice_sum_;
  for (std::size_t i = 0; i < position.size(); ++i) {
    Moments m;
    addNeighbours(near_.arrays(), i, per_radius2, m);
    const Eigen::Vector3f mean = m.x / m.w;
    Eigen::Matrix3f covariance;
    covariance << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
    covariance = covariance / m.w - mean * mean.transpose();
    const float lonely = std::clamp((1.0f - m.w * alone) / (1.0f - alone), 0.0f, 1.0f);
    const float b = floor_full + (floor_alone - floor_full) * lonely * lonely;
    const Eigen::Matrix3f square =
        radius_ * radius_ * ((1.0f - b) / lattice_var_ * covariance + b * Eigen::Matrix3f::Identity());
    EllipsoidKernel& kernel = kernels[i];
    kernel.centre = position.at(i) + smoothing * mean;
    kernel.shape = square.inverse();
    kernel.reach = square.diagonal().cwiseSqrt();
    const float shape[6] = {kernel.shape(0, 0), kernel.shape(0, 1), kernel.shape(0, 2),
                            kernel.shape(1, 1), kernel.shape(1, 2), kernel.shape(2, 2)};
    kernel.weight = 1.0f / kernelSum(near_.arrays(), i, shape);
  }
  return kernels;
}

}  // namespace tactile_clay::surface
