#pragma once

#include <utility>
#include <vector>

#include "clay/clay.h"

/// Blocks of clay and colliders that tests and benchmarks are made of, and what is measured on them.
namespace tactile_clay::clay {

/// A block on a cubic lattice, nx x ny x nz particles, standing on `foot`, the middle of its bottom face.
std::vector<InitialParticle> block(int nx, int ny, int nz, double spacing,
                                   const Eigen::Vector3d& foot = Eigen::Vector3d::Zero(),
                                   const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity(),
                                   std::uint8_t material = 0);

/// As config/materials/modelling_clay.yaml.
Material firmClay();

/// A thick slab whose top passes through the origin of the world, sloping down along x by `slope` rad.
Solid ground(double slope = 0.0);

/// A square skin of samples about `centre`, one every `pitch`, facing along `normal`.
Skin samplePlane(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double half, double pitch,
                 const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero());

/// The skin of a ball: points of a Fibonacci lattice about `pitch` apart.
Skin sampleBall(const Eigen::Vector3d& centre, double radius, double pitch,
                const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero());

void append(Skin& samples, const Skin& more);

// Sums over the particles, in double precision.

double mass(const Particles& p, std::size_t i);

double totalMass(const Particles& p);

Eigen::Vector3d centreOfMass(const Particles& p);

Eigen::Vector3d momentum(const Particles& p);

/// About the centre of mass, kg m^2/s.
Eigen::Vector3d angularMomentum(const Particles& p);

double kineticEnergy(const Particles& p);

double meanSpeed(const Particles& p);

/// Root mean square speed about the best rigid motion: 0 where the clay moves as one piece, m/s.
double internalSpeed(const Particles& p);

/// Extent of the particles along a direction: {lowest, highest}, m.
std::pair<double, double> extent(const Particles& p, const Eigen::Vector3d& direction);

bool allFinite(const Particles& p);

}  // namespace tactile_clay::clay
