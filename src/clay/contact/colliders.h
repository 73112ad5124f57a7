#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "clay/contact/skin_side.h"
#include "clay/solid.h"
#include "values/skin.h"

namespace tactile_clay::clay {

/// m, every coordinate of a skin sample that counts as not there.
constexpr float nowhere = 1e9f;

inline bool exists(const Skin& skin, std::size_t i) {
  return skin.position[i].x() < nowhere;
}

/// What may touch clay in a step.
struct Surroundings {
  const Skin& skin;  // at the end of the step; they move straight, with their velocities
  const std::vector<Solid>& solids;
  const std::vector<Eigen::Isometry3d>&start, &end;  // poses of the solids at the start and the end of it
  float dt;                                          // s
};

/// The skin and the solids in a step, and which places they leave free at its end.
class Colliders {
 public:
  struct MovingSolid {
    MovingSolid(const Solid& solid_in, const Eigen::Isometry3d& start, const Eigen::Isometry3d& end_in);
    /// Whether a point may come nearer to it than that.
    /// @param way m, what the point moves in the step
    bool mayMeet(const Eigen::Vector3d& point, double way, double near) const;

    Solid solid;
    Eigen::Isometry3d end;               // its pose at the end of the step
    Eigen::Isometry3d to_start, to_end;  // from world into its frame
    Eigen::AlignedBox3d box;             // m, about it at the start of the step
    double travel = 0.0;                 // m, what moves the farthest of it in the step
  };

  static constexpr float reach = 1.5f;  // spacings, R: samples this near make the skin at a place

  /// @param spacing m
  explicit Colliders(float spacing) : spacing_(spacing) {}

  /// Starts a step, which the samples must outlive.
  void begin(const Surroundings& around);

  const Skin& skin() const { return *skin_; }
  const std::vector<MovingSolid>& solids() const { return solids_; }

  /// Calls f(g) for all samples whose way may come within a radius of a point on its way, and others: for
  /// some that are beside each other, if one may. They come in any order; results that depend on it must be
  /// sorted.
  template <typename F>
  void forSamplesNear(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius,
                      const F& f) const {
    const Eigen::Array3f way = (to - from).array(), around = Eigen::Array3f::Constant(radius);
    const Eigen::AlignedBox3f whole(from.cwiseMin(to).array() - around, from.cwiseMax(to).array() + around);
    for (std::size_t b = 0; b < sample_boxes_.size(); ++b) {
      const Eigen::AlignedBox3f& box = sample_boxes_[b];
      if (!box.intersects(whole)) continue;
      // From when to when the point is between the sides of the box, axis by axis.
      const Eigen::Array3f low = (box.min() - from).array() - around,
                           high = (box.max() - from).array() + around;
      float enters = 0.0f, leaves = 1.0f;
      for (int a = 0; a < 3; ++a) {
        if (way[a] == 0.0f) continue;
        enters = std::max(enters, std::min(low[a] / way[a], high[a] / way[a]));
        leaves = std::min(leaves, std::max(low[a] / way[a], high[a] / way[a]));
      }
      if (enters > leaves + 1e-3f) continue;
      const std::size_t last = std::min(skin_->size(), (b + 1) * samples_a_box);
      for (std::size_t k = b * samples_a_box; k < last; ++k) f(order_.empty() ? k : order_[k]);
    }
  }

  /// Whether a place is beneath a sample's disc of skin, or less than `clearance`, m, above it; a sample
  /// covers what is beneath its disc, as far as flesh is thick.
  bool covers(std::uint32_t sample, const Eigen::Vector3f& place, float clearance) const;
  /// Whether a place is beneath the skin, beyond doubt.
  bool isInFlesh(const Eigen::Vector3f& x) const;
  bool isInSolid(const Eigen::Vector3f& x) const;

  /// The nearest of the places that neither the skin nor a solid covers, m: x itself, or places along the
  /// solids and the outside of the skin.
  /// @param clearance m, between them and a particle's centre
  /// @param maximum m, that it may be away
  /// @param looks how many samples and solids may be looked at; it becomes less by those that were, and the
  /// search ends where none are left
  /// @return none: there is none, or none was found by then
  std::optional<Eigen::Vector3f> nearestFree(const Eigen::Vector3f& x, float clearance, float maximum,
                                             std::int64_t& looks) const;

 private:
  static constexpr std::size_t samples_a_box = 32;

  void boxSamples(float dt);
  bool isScattered() const;
  void sortSamples();
  const std::vector<std::uint32_t>& samplesBeside(const Eigen::Vector3f& x, float maximum) const;
  template <typename F>
  void forSides(std::vector<NearSample>& rest, const Eigen::Vector3f& place, const F& f) const;

  float spacing_;
  // Of the step.
  const Skin* skin_ = nullptr;
  std::vector<MovingSolid> solids_;
  std::vector<std::uint32_t> order_;               // of the samples in the boxes; empty: their own
  std::vector<Eigen::AlignedBox3f> sample_boxes_;  // m, about the ways of each few samples
};

}  // namespace tactile_clay::clay
