#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "support/pressed_hand.h"

/// What the long runs of the soft hand are watched for, and joints that no hand has.
namespace tactile_clay::hand {

// Root mean square of the part of a force above 20 Hz, over the mean of the force.
// \param force N, of each frame
inline double buzz(const std::vector<double>& force) {
  const auto count = static_cast<int>(force.size());
  double mean = 0.0, power = 0.0;
  for (const double f : force) mean += f / count;
  for (int bin = 1; bin <= count / 2; ++bin) {
    if (bin / (count * frame) <= 20.0) continue;
    double re = 0.0, im = 0.0;
    for (int k = 0; k < count; ++k) {
      re += (force[k] - mean) * std::cos(2.0 * M_PI * bin * k / count);
      im += (force[k] - mean) * std::sin(2.0 * M_PI * bin * k / count);
    }
    power += 2.0 * (re * re + im * im) / (static_cast<double>(count) * count);
  }
  return std::sqrt(power) / mean;
}

// How many tetrahedra of flesh were inside out, and in how many successive frames.
class InsideOut {
 public:
  void see(const SoftHand& hand) {
    const int now = hand.inverted();
    maximum = std::max(maximum, now);
    on_end_ = now > 0 ? on_end_ + 1 : 0;
    longest = std::max(longest, on_end_);
  }
  int maximum = 0, longest = 0;  // tetrahedra, frames

 private:
  int on_end_ = 0;
};

// Joints at places that no hand has, off by about `size` m and turned at random.
inline TrackedHand scrambled(TrackedHand hand, double size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  for (JointPose& joint : hand.joints) {
    joint.position += size * Eigen::Vector3d(normal(random), normal(random), normal(random));
    joint.orientation =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
  }
  return hand;
}

}  // namespace tactile_clay::hand
