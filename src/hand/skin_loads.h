#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "hand/bound_skin.h"
#include "hand/hand_bodies.h"
#include "hand/neo_hookean.h"
#include "values/skin.h"

namespace tactile_clay::hand {

/// Loads of the clay on the flesh of one hand.
///
/// The clay answers one frame late and may be very stiff. So the force is taken as f - K (x - x_then), with K
/// an estimate of the clay's stiffness. This is a Robin condition, which is stable if K is more than half of
/// the true stiffness. A sample that the clay has just let go of keeps a load of zero force for a few frames:
/// it may leave freely, but its way back meets resistance. Otherwise it would fall through the whole frame
/// that the answer takes, and bounce.
class SkinLoads {
 public:
  /// @param skin points that the loads act on, by sample
  explicit SkinLoads(std::vector<FleshPoint> skin);

  /// Replaces all loads. Forces on one sample add up; doc/method/soft_hand.md lists their limits.
  /// @param given forces on samples of this skin, finite
  /// @param at m, points of all samples when the clay was given the skin
  void give(const std::vector<SkinForce>& given, const std::vector<Eigen::Vector3f>& at);
  void clear();
  /// Clears the loads, and resets the estimated stiffness of the clay.
  void reset();

  /// First half of a step: the loads as they were move the flesh.
  void apply(std::vector<FleshNode>& nodes);
  /// Second half of a step: computes the loads for the place where the flesh is now.
  void project(std::vector<FleshNode>& nodes);

  bool empty() const { return loads_.empty(); }
  std::array<bool, body_count> pressed() const;  // bodies with a load
  Eigen::Vector3d force() const;                 // N, sum in the last step
  double strength() const;                       // N, sum of the magnitudes in the last step

 private:
  struct Load {
    int sample;
    Eigen::Vector3f force;   // N, as given
    Eigen::Vector3f inward;  // unit, direction in which the clay pushes
    Eigen::Vector3f at;      // m, of the sample's point on the flesh
    int age;                 // frames since the clay let go; 0: it presses
    float stiffness;         // N/m
    Eigen::Vector3f now;     // N, in this step
  };

  void average(std::vector<Load>& next, const std::vector<Eigen::Vector3f>& at);
  void estimateStiffness(const std::vector<Load>& next, const std::vector<Eigen::Vector3f>& at);

  std::vector<FleshPoint> skin_;
  std::vector<Load> loads_;                  // by sample
  std::vector<Eigen::Vector3f> at_;          // m, of all samples when the loads were given
  std::array<float, body_count> stiffness_;  // N/m, of the clay at one sample, by body
};

}  // namespace tactile_clay::hand
