#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "clay/contact.h"
#include "clay/ghosts.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "clay/solid.h"

namespace tactile_clay::clay {

/// Finds where clay may touch solids and the skin in a step (paper, section III-D).
///
/// The skin is the weighted mean of the tangent planes of the ghosts within R of a particle (an implicit
/// moving least squares surface), so it is smooth between ghosts; it is one-sided, as in Macklin et al. 2014
/// ("Unified particle physics"): clay is pushed out along the ghosts' outward normals, never drawn in. Clay
/// particles stay half a spacing off every surface. Where ghosts of opposite sides are near (two fingers),
/// each side is a contact.
class ContactSearch {
 public:
  /// Of the contacts only the geometry is set: particle, solid, normal, gap, drift and ghosts.
  struct Found {
    std::vector<Contact> contacts;
    std::vector<GhostShare> shares;
  };

  /// m/s, at which an old penetration is undone, so that none explodes. Skin is quicker: what started inside
  /// of two solids has nowhere to go, and stores what they squeeze it by.
  static constexpr double solid_recovery_speed = 0.1;

  /// \param spacing m
  explicit ContactSearch(float spacing) : spacing_(spacing) {}

  /// What may touch in a step, in the order of the particles, and of each the skin first. The guess must
  /// outlive the step. \param before contacts of the step before, by particle \param guess, ghosts, solids,
  /// start, end as in Contacts::detect \return the caller's, until the next search
  Found& findAtStart(const std::vector<Contact>& before, const Neighbourhood& near,
                     const Particles& particles, const VectorField& guess, const Ghosts& ghosts,
                     const std::vector<Solid>& solids, const std::vector<Eigen::Isometry3d>& start,
                     const std::vector<Eigen::Isometry3d>& end, float dt);

  /// In the same step, what touches particles where they go through the skin or end, if u leads them
  /// elsewhere than the guess or far, in the order of the particles. \return good until the next search
  const Found& findStrays(const Particles& particles, const Ghosts& ghosts, const VectorField& u, float dt);

  /// The nearest of the places that neither the skin nor a solid covers at the end of the step, m: x itself,
  /// or places along the solids and the outside of the skin. \param clearance m, between them and a
  /// particle's centre \param most m, that it may be away \return none: there is none
  std::optional<Eigen::Vector3f> nearestFree(const Ghosts& ghosts, const Eigen::Vector3f& x, float clearance,
                                             float most) const;

  /// Whether a place is beneath a ghost's disc of skin at the end of the step, or less than `clearance`, m,
  /// above it; a ghost covers what is beneath its disc, as far as flesh is thick.
  bool covers(const Ghosts& ghosts, std::uint32_t ghost, const Eigen::Vector3f& place, float clearance) const;
  /// Whether a place is beneath the skin at the end of the step, beyond doubt.
  bool isInFlesh(const Ghosts& ghosts, const Eigen::Vector3f& x) const;
  /// Whether a place is in a solid at the end of the step.
  bool isInSolid(const Eigen::Vector3f& x) const;

 private:
  struct Step {                  // of the clay and the skin; everything moves straight
    const Particles& particles;  // at its start
    const VectorField& u;        // m, their displacements
    const Ghosts& ghosts;        // at its end
    float dt;                    // s
  };
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
  struct Candidate {  // ghost that may be part of the skin at a particle
    std::uint32_t particle, ghost;
    float nearest;  // m^2, the least squared distance in the step
  };
  struct SkinPlane {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit
    float distance = 0.0f, before = 0.0f;              // m, of x from it at the end and the start of the step
    Eigen::Vector3f drift = Eigen::Vector3f::Zero();   // m
  };

  void findCandidates(const Neighbourhood& near, const Step& step);
  void findPassing(const Neighbourhood& near, const Step& step, const Eigen::AlignedBox3f& ways,
                   std::uint32_t ghost, std::vector<Candidate>& candidates) const;
  void sortCandidates(std::size_t particles);
  void touchSkin(const std::vector<Contact>& before, const Step& step, std::size_t i, Found& found) const;
  double allowedDepth(double before, float dt) const;
  void touchSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const;
  template <typename F>
  void forGhostsNear(const Ghosts& ghosts, const Eigen::AlignedBox3f& box, const F& f) const;
  template <typename F>
  void forSidesAt(const Ghosts& ghosts, const std::vector<std::uint32_t>& of, const Eigen::Vector3f& place,
                  const F& f) const;
  std::vector<std::uint32_t> ghostsBeside(const Ghosts& ghosts, const Eigen::Vector3f& x, float most) const;
  bool isBeneathDisc(const Ghosts& ghosts, const std::vector<std::uint32_t>& of,
                     const Eigen::Vector3f& place) const;
  void strayIntoSkin(const Step& step, std::size_t i, Found& found) const;
  void findCrossed(const Step& step, std::size_t i, std::vector<Candidate>& crossed) const;
  void strayIntoSolid(const Step& step, std::size_t i, std::size_t s, Found& found) const;
  /// m, of x over a ghost's plane at the start of the step.
  static float heightAtStart(const Step& step, const Eigen::Vector3f& x, std::size_t ghost) {
    const Eigen::Vector3f at = step.ghosts.position[ghost] - step.dt * step.ghosts.velocity[ghost];
    return step.ghosts.normal[ghost].dot(x - at);
  }
  template <typename F>
  void touchSides(const Step& step, const Eigen::Vector3f& x, std::vector<Candidate>& rest, Found& found,
                  const F& touches) const;
  static void takeSide(const Ghosts& ghosts, std::vector<Candidate>& rest, std::vector<Candidate>& side);
  SkinPlane planeOf(const Ghosts& ghosts, float dt, const std::vector<Candidate>& side,
                    const Eigen::Vector3f& x, std::vector<GhostShare>& shares) const;
  template <typename F>
  void findEach(std::size_t n, std::size_t chunk_size, const F& find);

  float spacing_;
  // Of the step.
  const VectorField* guess_ = nullptr;
  std::vector<MovingSolid> solids_;
  std::vector<Eigen::AlignedBox3f> ghost_boxes_;  // m, about the ways of each few ghosts
  Found found_;
  // Kept for their memory.
  std::vector<Found> chunks_;
  std::vector<std::vector<Candidate>> passing_;  // by chunks of the ghosts
  std::vector<Candidate> candidates_;            // by particle
  std::vector<std::uint32_t> candidate_end_;     // of each particle, where the next one's begin
};

}  // namespace tactile_clay::clay
