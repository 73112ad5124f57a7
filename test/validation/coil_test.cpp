#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "support/samples.h"

/// A coil of clay is rolled on a table under a plate, as under a palm. Measured figures are in
/// doc/method/validation.md.
namespace tactile_clay::clay::coil_test {
namespace {

/// Size of a body by its second moments: the elliptic cylinder that has the same.
struct Cylinder {
  double length, area, narrow_over_wide;  // m, m^2, of the axes of the section

  Cylinder(const Particles& p, double spacing) {
    const Eigen::Vector3d centre = centreOfMass(p);
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Eigen::Vector3d x = p.position.at(i).cast<double>() - centre;
      moments += x * x.transpose() / static_cast<double>(p.size());
    }
    moments += spacing * spacing / 12.0 * Eigen::Matrix3d::Identity();  // of the cube of a particle
    const Eigen::Vector3d squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvalues();
    length = std::sqrt(12.0 * squares[2]);
    area = 4.0 * M_PI * std::sqrt(squares[0] * squares[1]);
    narrow_over_wide = std::sqrt(squares[0] / squares[1]);
  }
};

/// A coil along y between a table and a plate that moves to and fro along x, once a second, and presses with
/// about the same force, as a palm does. A coil that is cut out of a lattice has corners: a plate at a fixed
/// height would lose it.
struct Rolled {
  static constexpr double radius = 0.03, length = 0.12, travel = 0.2;  // m
  static constexpr int period = 60;                                    // frames
  static constexpr double speed = 0.02;                                // m/s, of the plate down without force

  explicit Rolled(const Resolution& r, const Material& m = firmClay())
      : clay(withWeight(r), {m}, lying(cylinder(radius, length, r.spacing))), plates(2.0 * radius, bite) {}
  static ClayConfig withWeight(const Resolution& r) {
    ClayConfig config = weightless(r);
    config.gravity = {0.0, 0.0, -9.81};
    return config;
  }
  static std::vector<InitialParticle> lying(std::vector<InitialParticle> particles) {
    for (InitialParticle& p : particles) {
      const Eigen::Vector3f x = p.position;
      p.position = {x.x(), x.z() - static_cast<float>(0.5 * length), x.y() + static_cast<float>(radius)};
    }
    return particles;
  }
  double gap() const { return plates.upper.pose.translation().z() - 0.1; }
  double moved() const { return plates.upper.pose.translation().x(); }
  /// Presses without moving to and fro, so that the plate has a grip.
  void press(double force) {
    for (int k = 0; k < period / 4; ++k) move(0.0, force);
  }
  /// A frame, in which the plate moves along x and presses.
  void move(double along, double force) {
    const double now = clay.time() > 0.0 ? Plates::force(clay).z() : 0.0;
    const double down = speed * std::min(1.0, std::max(-1.0, 1.0 - now / force));
    plates.upper.linear_velocity = {along / clay.config().frame, 0.0, -down};
    plates.advance(clay);
  }
  /// Moves the plate for some periods and presses.
  /// @param force N
  /// @param each is called after each frame
  template <typename Each>
  void roll(int periods, double force, const Each& each) {
    const auto place = [](int k) { return 0.5 * travel * (1.0 - std::cos(2.0 * M_PI * k / period)); };
    for (int k = 0; k < periods * period; ++k) {
      move(place(k + 1) - place(k), force);
      each();
    }
  }
  /// Turning of the clay about y, rad/s.
  double spin() const {
    const Particles& p = clay.particles();
    const Eigen::Vector3d centre = centreOfMass(p);
    double squares = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Eigen::Vector3d x = p.position.at(i).cast<double>() - centre;
      squares += mass(p, i) * (x.x() * x.x() + x.z() * x.z());
    }
    return angularMomentum(p).y() / squares;
  }

  Clay clay;
  Plates plates;
};

constexpr double palm = 40.0;  // N

/// Rolling without slip: the clay that touches the table rests, that at the plate moves with it, so the
/// centre is at half of the plate's way. Within 5 % of the longest way. In half a period the clay turns by
/// the way over its diameter. This is between the gap and the gap less a spacing, because colliders hold the
/// middles of particles. Within 2 %, by which the gap is not the diameter.
void rollsAtHalfTheSpeedOfThePlate(const Resolution& resolution) {
  Rolled coil(resolution);
  coil.press(palm);
  const double start = centreOfMass(coil.clay.particles()).x();
  double turned = 0.0, most = 0.0;
  int frame = 0;
  coil.roll(1, palm, [&] {
    if (++frame <= Rolled::period / 2) turned += coil.clay.config().frame * coil.spin();
    most = std::max(most, std::abs(centreOfMass(coil.clay.particles()).x() - start - 0.5 * coil.moved()));
  });
  EXPECT_LT(most, 0.05 * Rolled::travel);
  const double diameter = Rolled::travel / turned;
  ::testing::Test::RecordProperty("diameter", std::to_string(diameter));
  ::testing::Test::RecordProperty("off_half", std::to_string(most / Rolled::travel));
  EXPECT_LT(diameter, 1.02 * 2.0 * Rolled::radius);
  EXPECT_GT(diameter, 0.98 * (coil.gap() - resolution.spacing));
}

TEST(Coil, RollsAtHalfTheSpeedOfThePlate) {
  rollsAtHalfTheSpeedOfThePlate({{8, 16}, 0.005});
}
TEST(Coil, RollsAtHalfTheSpeedOfThePlateAtAFinerSpacing) {
  rollsAtHalfTheSpeedOfThePlate({{8, 16}, 0.00375});
}
TEST(Coil, RollsAtBalanced) {
  rollsAtHalfTheSpeedOfThePlate({{4, 8}, 0.005});
}

/// In some periods the plate sinks. The coil keeps its volume: length times area, by second moments, is that
/// at the start within 2 %, as these moments are off by 1.4 % for a lattice of six rows. So it gets longer,
/// by more than a twentieth, as it gets thinner. It stays round: its axes are equal within 10 %. So its
/// length is V / (pi gap^2 / 4) within 10 %. It stays in one piece.
void getsLonger(const Resolution& resolution, int periods) {
  Rolled coil(resolution);
  const Particles& p = coil.clay.particles();
  const double d = resolution.spacing;
  const Cylinder before(p, d);
  coil.press(palm);
  coil.roll(periods, palm, [] {});
  const Cylinder after(p, d);
  const double volume = std::pow(d, 3.0) * static_cast<double>(p.size());
  const double expected = volume / (0.25 * M_PI * coil.gap() * coil.gap());
  ::testing::Test::RecordProperty("longer", std::to_string(after.length / before.length));
  ::testing::Test::RecordProperty("length", std::to_string(after.length / expected));
  ::testing::Test::RecordProperty("volume",
                                  std::to_string(after.length * after.area / before.length / before.area));
  ::testing::Test::RecordProperty("narrow_over_wide", std::to_string(after.narrow_over_wide));
  EXPECT_NEAR(after.length * after.area, before.length * before.area, 0.02 * before.length * before.area);
  EXPECT_GT(after.length, 1.05 * before.length);
  EXPECT_NEAR(after.length, expected, 0.1 * expected);
  EXPECT_GT(after.narrow_over_wide, 0.9);
  EXPECT_EQ(coil.clay.statistics().lumps, 1u);
}

TEST(Coil, GetsLongerAsItGetsThinner) {
  getsLonger({{8, 16}, 0.005}, 4);
}

}  // namespace
}  // namespace tactile_clay::clay::coil_test
