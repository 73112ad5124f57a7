#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "hand/neo_hookean.h"
#include "hand/soft_hand_template.h"
#include "values/skin.h"

namespace tactile_clay::hand {

/// Where a sample of the skin sits on the flesh: a point of a triangle.
struct FleshPoint {
  std::array<int, 3> node;
  Eigen::Vector3f share;  // barycentric
  std::uint8_t body;      // that the flesh there belongs to

  Eigen::Vector3f position(const std::vector<FleshNode>& nodes) const {  // m
    return share[0] * nodes[node[0]].head<3>() + share[1] * nodes[node[1]].head<3>() +
           share[2] * nodes[node[2]].head<3>();
  }
};

/// The skin's samples of one hand, bound to the surface of its flesh.
class BoundSkin {
 public:
  /// @param skin the samples at the rest pose of a hand of `scale`; those of the template's side are bound
  /// @throws std::logic_error where there is no flesh beneath a sample
  BoundSkin(const SoftHandTemplate& anatomy, const Skin& skin, double scale);

  std::size_t size() const { return points_.size(); }
  const std::vector<FleshPoint>& points() const { return points_; }

  /// Appends the skin on flesh as it is, of a hand of `scale`, with velocities zero.
  void appendTo(Skin& skin, const SoftHandTemplate& anatomy, const std::vector<FleshNode>& nodes,
                float scale) const;

 private:
  /// What lies between the sample and its point, in the frame of (edge, smooth normal), and what it stands
  /// for; all at rest at scale 1.
  struct Sample {
    Eigen::Vector3f offset;    // m
    Eigen::Vector3f normal;    // unit
    float triangle_area;       // m^2
    float area, pad_distance;  // m^2, m
    std::uint8_t region;
  };

  std::vector<FleshPoint> points_;
  std::vector<Sample> samples_;
};

}  // namespace tactile_clay::hand
