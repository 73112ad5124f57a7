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
/// The clay answers one frame late and as stiffly as it likes, so the force is taken as f - K (x - x_then),
/// with K an estimate of the clay's stiffness: a Robin condition, which is stable where K is more than half
/// of the true one. A sample that the clay has just let go of keeps a load of zero force for a few frames:
/// it may leave freely and comes back with care, or it would fall through the whole frame that the answer
/// takes, and bounce.
class SkinLoads {
 public:
  /// @param skin what the loads act on, by sample
  explicit SkinLoads(std::vector<FleshPoint> skin);

  /// Replaces all loads. Forces on one sample add up; bounds on them are told in doc/method/soft_hand.md.
  /// @param given of samples of this skin, finite
  /// @param at m, of all samples when the clay was given the skin
  void give(const std::vector<SkinForce>& given, const std::vector<Eigen::Vector3f>& at);
  void clear();
  /// Clears, and forgets what was learnt of the clay.
  void reset();

  /// A step: what the loads were moves the flesh, ...
  void apply(std::vector<FleshNode>& nodes);
  /// ... and what they are where the flesh has gone.
  void project(std::vector<FleshNode>& nodes);

  bool empty() const { return loads_.empty(); }
  std::array<bool, body_count> pressed() const;  // bodies with a load
  Eigen::Vector3d force() const;                 // N, in the last step
  double strength() const;                       // N, the same, of each load by itself

 private:
  struct Load {
    int sample;
    Eigen::Vector3f force;   // N, as given
    Eigen::Vector3f inward;  // unit, in which the clay pushes
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
