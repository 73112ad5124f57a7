#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "clay/ghosts.h"
#include "clay/solid.h"

namespace tactile_clay::clay {

/// The skin and the solids in a step, and which places they leave free at its end.
class Obstacles {
 public:
  struct MovingSolid {
    MovingSolid(const Solid& solid_in, const Eigen::Isometry3d& start, const Eigen::Isometry3d& end_in);
    /// Whether a point may come nearer to it than that. \param way m, what the point moves in the step
    bool mayMeet(const Eigen::Vector3d& point, double way, double near) const;

    Solid solid;
    Eigen::Isometry3d end;               // its pose at the end of the step
    Eigen::Isometry3d to_start, to_end;  // from world into its frame
    Eigen::AlignedBox3d box;             // m, about it at the start of the step
    double travel = 0.0;                 // m, what moves the farthest of it in the step
  };

  static constexpr float reach = 1.5f;  // spacings, R: ghosts this near make the skin at a place

  /// \param spacing m
  explicit Obstacles(float spacing) : spacing_(spacing) {}

  /// Starts a step. \param ghosts, solids, start, end as in Contacts::detect; ghosts must outlive the step
  void begin(const Ghosts& ghosts, const std::vector<Solid>& solids,
             const std::vector<Eigen::Isometry3d>& start, const std::vector<Eigen::Isometry3d>& end,
             float dt);

  const Ghosts& ghosts() const { return *ghosts_; }
  const std::vector<MovingSolid>& solids() const { return solids_; }

  /// Calls f(g), in order, for all ghosts whose way may come into a box, and others: for some that follow
  /// each other, and so are beside each other, if one may.
  template <typename F>
  void forGhostsNear(const Eigen::AlignedBox3f& box, const F& f) const {
    for (std::size_t b = 0; b < ghost_boxes_.size(); ++b) {
      if (!ghost_boxes_[b].intersects(box)) continue;
      const std::size_t last = std::min(ghosts_->size(), (b + 1) * ghosts_a_box);
      for (std::size_t g = b * ghosts_a_box; g < last; ++g) f(g);
    }
  }

  /// Whether a place is beneath a ghost's disc of skin, or less than `clearance`, m, above it; a ghost covers
  /// what is beneath its disc, as far as flesh is thick.
  bool covers(std::uint32_t ghost, const Eigen::Vector3f& place, float clearance) const;
  /// Whether a place is beneath the skin, beyond doubt.
  bool isInFlesh(const Eigen::Vector3f& x) const;
  bool isInSolid(const Eigen::Vector3f& x) const;

  /// The nearest of the places that neither the skin nor a solid covers, m: x itself, or places along the
  /// solids and the outside of the skin. \param clearance m, between them and a particle's centre \param most
  /// m, that it may be away \return none: there is none
  std::optional<Eigen::Vector3f> nearestFree(const Eigen::Vector3f& x, float clearance, float most) const;

 private:
  static constexpr std::size_t ghosts_a_box = 32;

  template <typename F>
  void forSidesAt(const std::vector<std::uint32_t>& of, const Eigen::Vector3f& place, const F& f) const;
  const std::vector<std::uint32_t>& ghostsBeside(const Eigen::Vector3f& x, float most) const;
  bool isBeneathDisc(const std::vector<std::uint32_t>& of, const Eigen::Vector3f& place) const;

  float spacing_;
  // Of the step.
  const Ghosts* ghosts_ = nullptr;
  std::vector<MovingSolid> solids_;
  std::vector<Eigen::AlignedBox3f> ghost_boxes_;  // m, about the ways of each few ghosts
};

/// m, about a way.
inline Eigen::AlignedBox3f boxAbout(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius) {
  const Eigen::Vector3f around = Eigen::Vector3f::Constant(radius);
  return {from.cwiseMin(to) - around, from.cwiseMax(to) + around};
}

}  // namespace tactile_clay::clay
