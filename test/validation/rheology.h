#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "support/samples.h"

/// What viscosity, stiffness and yield stress are measured on: a twisted cylinder, a film on a wall, a bar.
namespace tactile_clay::clay {

/// A free cylinder that is twisted to and fro by v = omega cos(pi z / L) e_z x r. No stress acts on its
/// surface, so this is a mode of a Newtonian fluid, with the rate eta (pi / L)^2 / rho, and of an elastic
/// solid, with the frequency (pi / L) sqrt(G / rho) (Love 1927, art. 200). There are no walls.
struct Twisted {
  static constexpr double radius = 0.03, length = 0.06, wave_number = M_PI / length;
  static constexpr double turn = 37.0 * M_PI / 180.0;

  Twisted(const Resolution& resolution, const Material& material, double speed, bool turned) {
    const Eigen::Matrix3d lattice =
        Eigen::AngleAxisd(turned ? turn : 0.0, Eigen::Vector3d(1.0, 0.5, 0.2).normalized())
            .toRotationMatrix();
    auto particles = cylinder(radius, length, resolution.spacing, lattice);
    for (InitialParticle& p : particles) {
      const double spin = speed * std::cos(wave_number * static_cast<double>(p.position.z()));
      p.velocity = static_cast<float>(spin) * Eigen::Vector3f(-p.position.y(), p.position.x(), 0.0f);
      start.push_back(p.position.cast<double>());
    }
    clay = std::make_unique<Clay>(weightless(resolution), std::vector<Material>{material}, particles);
  }
  /// Amplitude of the mode, rad/s.
  double amplitude() const {
    double sum = 0.0, norm = 0.0;
    for (std::size_t i = 0; i < start.size(); ++i) {
      const double weight = std::cos(wave_number * start[i].z());
      const Eigen::Vector3d arm(-start[i].y(), start[i].x(), 0.0);
      sum += weight * arm.dot(clay->particles().velocity.at(i).cast<double>());
      norm += weight * weight * arm.squaredNorm();
    }
    return sum / norm;
  }
  double timeStep() const { return clay->config().frame / clay->config().budget.substeps; }

  std::vector<Eigen::Vector3d> start;
  std::unique_ptr<Clay> clay;
};

struct FilmSize {
  double length = 0.15, width = 0.03;  // m
};

/// A film that sticks to a wall at z = 0 and is driven by gravity along the wall; a part of gravity presses
/// it on. The layer that touches the wall is held, so heights count from it. Near its free ends, and in the
/// columns at its free sides, it flows otherwise than a film without ends.
struct Film {
  static constexpr double thickness = 0.045;

  Film(const Resolution& r, const Material& material, double gravity, FilmSize size = {})
      : d(r.spacing),
        length(size.length),
        layers(static_cast<int>(std::lround(thickness / d))),
        height(thickness - 0.5 * d),
        start(block(static_cast<int>(std::lround(size.length / d)),
                    static_cast<int>(std::lround(size.width / d)), layers, d)),
        clay(pulled(r, gravity), {material}, start) {}
  static ClayConfig pulled(const Resolution& r, double gravity) {
    ClayConfig config = weightless(r);
    config.gravity = {gravity, 0.0, -0.3 * gravity};
    return config;
  }
  void run(int frames) {
    for (int k = 0; k < frames; ++k) clay.advance({}, {wall.lower}, clay.config().frame);
  }
  /// Mean speed of each layer, m/s, away from the ends.
  std::vector<double> profile() const {
    std::vector<double> speed(layers, 0.0), count(layers, 0.0);
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (std::abs(start[i].position.x()) > 0.15 * length) continue;
      const int layer = static_cast<int>(static_cast<double>(start[i].position.z()) / d);
      speed[layer] += static_cast<double>(clay.particles().velocity.at(i).x());
      count[layer] += 1.0;
    }
    for (int k = 0; k < layers; ++k) speed[k] /= count[k];
    return speed;
  }

  double d, length;
  int layers;
  double height;  // m, of the free surface over the layer that is held
  std::vector<InitialParticle> start;
  Clay clay;
  Plates wall{1.0, bite};
};

/// A bar of N x N columns between plates without friction, pressed, held and let go.
struct Bar {
  static constexpr double width = 0.03, length = 0.045, speed = 0.2;  // m, m, strain a second

  Bar(const Resolution& r, const Material& material)
      : columns(static_cast<int>(std::lround(width / r.spacing))),
        layers(static_cast<int>(std::lround(length / r.spacing))),
        gap((layers - 1) * r.spacing),
        clay(weightless(r), {material}, block(columns, columns, layers, r.spacing)),
        plates(layers * r.spacing) {}
  static Material slippery(double yield_strain) {
    Material m;
    m.viscosity = 50.0;
    m.friction = 0.0;
    m.yield_strain = yield_strain;
    return m;
  }
  /// Presses the bar to a strain, and holds it for a tenth of a second.
  /// @return Pa, force over the first area
  double pressTo(double to) {
    const int frames = static_cast<int>(std::lround(std::abs(to - strain) / speed / clay.config().frame));
    plates.upper.linear_velocity.z() = -gap * (to - strain) / (frames * clay.config().frame);
    for (int k = 0; k < frames; ++k) plates.advance(clay);
    plates.upper.linear_velocity.setZero();
    for (int k = 0; k < 6; ++k) plates.advance(clay);
    strain = to;
    return stress();
  }
  double stress() const { return Plates::force(clay).z() / (width * width); }
  /// Strain of the clay between the middles of its ends; it may have left the plate and lean a little.
  double clayStrain() const { return 1.0 - (meanHeight(layers - 1) - meanHeight(0)) / gap; }
  double meanHeight(int layer) const {
    const int number = columns * columns;
    double sum = 0.0;
    for (int i = layer * number; i < (layer + 1) * number; ++i)
      sum += static_cast<double>(clay.particles().position.at(i).z());
    return sum / number;
  }

  int columns, layers;
  double gap, strain = 0.0;
  Clay clay;
  Plates plates;
};

}  // namespace tactile_clay::clay
