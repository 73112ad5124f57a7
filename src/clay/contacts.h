#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "clay/ghosts.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "clay/solid.h"

namespace tactile_clay::clay {

/// Contact of a particle with one side of an obstacle during a step: n . u >= gap (impenetrability), and
/// friction.
struct Contact {
  enum class State : std::uint8_t { open, slide, stick };
  static constexpr std::uint32_t skin = 0xffffffffu;

  std::uint32_t particle = 0;
  std::uint32_t solid = skin;  // index of the solid, or `skin`
  State state = State::open;
  float gap = 0.0f;                                  // m, least displacement along the normal
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, out of the obstacle
  Eigen::Vector3f drift =
      Eigen::Vector3f::Zero();  // m, displacement of the obstacle at the contact in this step
  Eigen::Vector3f anchor = Eigen::Vector3f::Zero();  // m, from the particle before the step; after it, from
                                                     // the particle then
  float stiffness = 0.0f;                            // N/m, of the friction spring
  float damping = 0.0f;  // N/m, of the friction of a slide; 0: it is `friction`, whatever the slip
  float paid = 0.0f;     // J, at the end of the step: what the friction spring may store
  float density = 0.0f;  // of rho_0, see BoundaryDensity
  Eigen::Vector3f friction = Eigen::Vector3f::Zero();  // N, tangential force on the particle while it slides
  Eigen::Vector3f force = Eigen::Vector3f::Zero();     // N, on the particle, this step
  std::uint32_t first_ghost = 0, ghost_count = 0;      // of a skin contact, in Contacts::shares()
};

/// A ghost's share in a contact.
struct GhostShare {
  std::uint32_t ghost;
  float share;  // the shares of a contact add up to one
};

/// Impenetrability and Coulomb friction against ghost particles and solids (paper, section III-D).
///
/// The skin is the weighted mean of the tangent planes of the ghosts within R of a particle (an implicit
/// moving least squares surface), so it is smooth between ghosts; it is one-sided, as in Macklin et al. 2014
/// ("Unified particle physics"): clay is pushed out along the ghosts' outward normals, never drawn in. Clay
/// particles stay half a spacing off every surface. Where ghosts of opposite sides are near (two fingers),
/// each side is a contact.
///
/// Impenetrability prescribes the displacement along the normal ("filtered" directions, Baraff & Witkin
/// 1998): the residual there is the force of the contact, the sum of Eq. 6. Friction is a sliding anchor: a
/// tangential spring holds the particle at its anchor; once its force leaves the Coulomb cone, the particle
/// slides under mu times the normal force and drags the anchor along, at the distance that this force gives.
/// The spring is as stiff as the load asks, so that this distance is a hundredth of a spacing.
class Contacts {
 public:
  /// \param materials friction is theirs; \param spacing m
  Contacts(float spacing, const std::vector<Material>& materials);

  /// Starts a step: finds what may touch in it and recalls the state of what touched before.
  /// \param guess displacements, m, that the particles would make freely
  /// \param ghosts at the end of the step; they move straight, with their velocities
  /// \param start, end poses of the solids at the start and the end of the step
  void detect(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
              const Ghosts& ghosts, const std::vector<Solid>& solids,
              const std::vector<Eigen::Isometry3d>& start, const std::vector<Eigen::Isometry3d>& end,
              float dt);

  /// Contacts of particles that u leads elsewhere than the guess: with solids that they end in, and with the
  /// skin there, which over such a way is no plane any more. \param ghosts those of `detect` \return whether
  /// there are any
  bool detectStrays(const Particles& particles, const Ghosts& ghosts, const VectorField& u, float dt);

  /// Closes open contacts that u violates, and moves particles to where their closed contacts prescribe.
  void prescribe(VectorField& u);

  /// From here to the next `update`, slides are damped: their friction is opposite to the slip, in proportion
  /// to it, and what it is now at the slip that u has. It then takes energy whatever the slip becomes.
  void dampSlides(const Particles& particles, const VectorField& u, float dt);

  // The next three work on the particles [first, last).
  /// Removes the prescribed directions from a field.
  void filter(std::size_t first, std::size_t last, VectorField& field) const;
  /// Adds the friction at the displacements u to the forces, N.
  void addFriction(const VectorField& u, std::size_t first, std::size_t last, VectorField& force) const;
  /// Adds the change of friction with the displacements p to the forces.
  void addFrictionChange(const VectorField& p, std::size_t first, std::size_t last, VectorField& force) const;

  /// Friction of a contact at the displacements u, N.
  Eigen::Vector3f frictionOn(const Contact& c, const VectorField& u) const;

  /// Reads the contact forces off the residual r = (forces - M a) on the particles, N, and changes states: a
  /// contact that pulls opens; one outside the Coulomb cone slides, one inside sticks.
  /// \return whether any contact acts otherwise from now on
  bool update(const Particles& particles, const VectorField& u, const VectorField& residual);

  /// Pushes out what still penetrates, and adds the force of doing so.
  void expel(const Particles& particles, VectorField& u, float dt);

  /// Ends a step: slides anchors.
  void finish(const Particles& particles, float dt);

  const std::vector<Contact>& contacts() const { return contacts_; }
  /// For a solver that sets states, anchors and forces itself; particles, solids and order must stay.
  std::vector<Contact>& contacts() { return contacts_; }
  const std::vector<GhostShare>& shares() const { return shares_; }

 private:
  struct Filter {
    std::uint32_t particle;
    std::uint32_t first, last;  // contacts [first, last) of the particle
    int rank = 0;               // prescribed directions
    Eigen::Matrix3f free;       // projector onto the free directions
  };
  struct Candidate {
    std::uint32_t particle, ghost;
    float nearest;  // m^2, the least squared distance in the step
  };
  struct Found {  // by one task of a search
    std::vector<Candidate> candidates;
    std::vector<Contact> contacts;
    std::vector<GhostShare> shares;
    bool turned = false;  // whether contacts that were there have other planes now
  };
  void detectSkin(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
                  const Ghosts& ghosts, float dt);
  void findCandidates(const Neighbourhood& near, const VectorField& guess, const Ghosts& ghosts, float dt,
                      const Eigen::AlignedBox3f& guesses, std::size_t first, std::size_t last,
                      std::vector<Candidate>& candidates) const;
  void touchSkin(const Particles& particles, const VectorField& guess, const Ghosts& ghosts, float dt,
                 std::size_t first, std::size_t last, Found& found) const;
  struct SkinPlane {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit
    float distance = 0.0f, before = 0.0f;              // m, of x from it at the end and the start of the step
    Eigen::Vector3f drift = Eigen::Vector3f::Zero();   // m
  };
  SkinPlane planeOf(const Ghosts& ghosts, const std::vector<Candidate>& side, const Eigen::Vector3f& x,
                    float dt, std::vector<GhostShare>& shares) const;
  static void takeSide(const Ghosts& ghosts, std::vector<Candidate>& rest, std::vector<Candidate>& side);
  void add(const Found& found);
  void detectSolids(const Particles& particles, const VectorField& guess, const std::vector<Solid>& solids,
                    const std::vector<Eigen::Isometry3d>& start, const std::vector<Eigen::Isometry3d>& end,
                    float dt);
  /// Calls f(filter) for the filters of particles [first, last).
  template <typename F>
  void forFilters(std::size_t first, std::size_t last, const F& f) const;
  float friction(const Contact& c, const Particles& particles) const;
  float adhesion(const Contact& c, const Particles& particles) const;
  float leastStiffness(const Contact& c, const Particles& particles, float dt) const;
  void recall(const Particles& particles, float dt);
  void strayIntoSkin(const Particles& particles, const Ghosts& ghosts, std::uint32_t i, const VectorField& u,
                     float dt, Found& found);
  void sortContacts();
  std::size_t firstOf(std::uint32_t particle) const;  // contact
  bool isListed(const Contact& contact) const;
  Eigen::Vector3f prescribed(Filter& filter, Eigen::Vector3f u);
  Eigen::Vector3f pull(const Contact& c, const Eigen::Vector3f& u) const;

  float spacing_;
  std::vector<float> friction_, skin_friction_;  // of each material
  std::vector<float> adhesion_;                  // N, of one particle of each material
  const VectorField* guess_ = nullptr;           // of the step
  std::vector<Solid> solids_;                    // of the step
  std::vector<Eigen::Isometry3d> solids_end_;    // their poses at its end
  std::vector<Contact> contacts_, previous_;
  std::vector<GhostShare> shares_;
  std::vector<Filter> filters_;  // one a touched particle
  std::vector<Found> found_;
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> runs_, candidate_place_;
};

}  // namespace tactile_clay::clay
