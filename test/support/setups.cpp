#include "support/setups.h"

#include <algorithm>
#include <cmath>

namespace tactile_clay::clay {

std::vector<InitialParticle> block(int nx, int ny, int nz, double spacing, const Eigen::Vector3d& foot,
                                   const Eigen::Matrix3d& rotation, std::uint8_t material) {
  std::vector<InitialParticle> particles;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const Eigen::Vector3d local =
            spacing * Eigen::Vector3d(x - 0.5 * (nx - 1), y - 0.5 * (ny - 1), z + 0.5);
        InitialParticle p;
        p.position = (foot + rotation * local).cast<float>();
        p.velocity.setZero();
        p.material = material;
        particles.push_back(p);
      }
    }
  }
  return particles;
}

Material firmClay() {
  Material clay;
  clay.density = 1600.0;
  clay.viscosity = 200.0;
  clay.stiffness = 1e6;
  clay.bulk_modulus = 1e7;
  clay.bond_rate = 1.0;
  clay.unbond_rate = 10.0;
  clay.yield_strain = 0.005;
  clay.friction = 0.6;
  return clay;
}

Solid ground(double slope) {
  Solid solid;
  solid.name = "ground";
  solid.shape = Solid::Shape::box;
  solid.size = {2.0, 2.0, 0.1};
  solid.pose.linear() = Eigen::AngleAxisd(slope, Eigen::Vector3d::UnitY()).toRotationMatrix();
  solid.pose.translation() = solid.pose.linear() * Eigen::Vector3d(0.0, 0.0, -0.1);
  return solid;
}

Skin samplePlane(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double half, double pitch,
                 const Eigen::Vector3d& velocity) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal);
  const int reach = static_cast<int>(std::lround(half / pitch));
  Skin samples;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      samples.position.push_back((centre + turn * Eigen::Vector3d(pitch * i, pitch * j, 0.0)).cast<float>());
      samples.normal.push_back(normal.normalized().cast<float>());
      samples.velocity.push_back(velocity.cast<float>());
    }
  }
  return samples;
}

Skin sampleBall(const Eigen::Vector3d& centre, double radius, double pitch, const Eigen::Vector3d& velocity) {
  const int count = static_cast<int>(std::ceil(4.0 * M_PI * radius * radius / (pitch * pitch)));
  Skin samples;
  for (int k = 0; k < count; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / count, rho = std::sqrt(1.0 - z * z);
    const double angle = M_PI * (3.0 - std::sqrt(5.0)) * k;
    const Eigen::Vector3d normal(rho * std::cos(angle), rho * std::sin(angle), z);
    samples.position.push_back((centre + radius * normal).cast<float>());
    samples.normal.push_back(normal.cast<float>());
    samples.velocity.push_back(velocity.cast<float>());
  }
  return samples;
}

void append(Skin& samples, const Skin& more) {
  samples.position.insert(samples.position.end(), more.position.begin(), more.position.end());
  samples.normal.insert(samples.normal.end(), more.normal.begin(), more.normal.end());
  samples.velocity.insert(samples.velocity.end(), more.velocity.begin(), more.velocity.end());
}

double mass(const Particles& p, std::size_t i) {
  return 1.0 / static_cast<double>(p.inverse_mass[i]);
}

double totalMass(const Particles& p) {
  double total = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) total += mass(p, i);
  return total;
}

Eigen::Vector3d centreOfMass(const Particles& p) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < p.size(); ++i) sum += mass(p, i) * p.position.at(i).cast<double>();
  return sum / totalMass(p);
}

Eigen::Vector3d momentum(const Particles& p) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < p.size(); ++i) sum += mass(p, i) * p.velocity.at(i).cast<double>();
  return sum;
}

Eigen::Vector3d angularMomentum(const Particles& p) {
  const Eigen::Vector3d centre = centreOfMass(p);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Eigen::Vector3d r = p.position.at(i).cast<double>() - centre;
    sum += mass(p, i) * r.cross(p.velocity.at(i).cast<double>());
  }
  return sum;
}

double kineticEnergy(const Particles& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    sum += 0.5 * mass(p, i) * p.velocity.at(i).cast<double>().squaredNorm();
  }
  return sum;
}

double meanSpeed(const Particles& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += p.velocity.at(i).norm();
  return sum / static_cast<double>(std::max<std::size_t>(p.size(), 1));
}

double internalSpeed(const Particles& p) {
  const std::size_t n = p.size();
  const Eigen::Vector3d centre = centreOfMass(p), drift = momentum(p) / totalMass(p);
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d r = p.position.at(i).cast<double>() - centre;
    inertia += mass(p, i) * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d spin = inertia.ldlt().solve(angularMomentum(p));
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d r = p.position.at(i).cast<double>() - centre;
    sum += (p.velocity.at(i).cast<double>() - drift - spin.cross(r)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(n));
}

std::pair<double, double> extent(const Particles& p, const Eigen::Vector3d& direction) {
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double x = direction.dot(p.position.at(i).cast<double>());
    low = std::min(low, x);
    high = std::max(high, x);
  }
  return {low, high};
}

bool allFinite(const Particles& p) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!p.position.at(i).allFinite() || !p.velocity.at(i).allFinite()) return false;
  }
  return true;
}

}  // namespace tactile_clay::clay
