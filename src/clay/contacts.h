#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "clay/contact.h"
#include "clay/contact_search.h"
#include "clay/ghosts.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/obstacles.h"
#include "clay/particles.h"
#include "clay/solid.h"

namespace tactile_clay::clay {

/// Impenetrability and Coulomb friction against ghost particles and solids (paper, section III-D).
///
/// Impenetrability prescribes the displacement along the normal ("filtered" directions, Baraff & Witkin
/// 1998): the residual there is the force of the contact, the sum of Eq. 6. Friction is a sliding anchor: a
/// tangential spring holds the particle at its anchor; once its force leaves the Coulomb cone, the particle
/// slides under mu times the normal force and drags the anchor along, at the distance that this force gives.
/// The spring is as stiff as the load asks, so that this distance is a hundredth of a spacing.
class Contacts {
 public:
  /// Ghosts that `release` looks at in a step, for all particles together and but for the last look of each:
  /// some 0.2 s. Hands that knead at the shipped scenes' pace need none of it.
  static constexpr std::int64_t most_looks = 20'000'000;

  /// \param materials friction is theirs; \param spacing m
  Contacts(float spacing, const std::vector<Material>& materials);

  /// Starts a step: finds what may touch in it and recalls the state of what touched before.
  /// \param guess displacements, m, that the particles would make freely
  /// \param ghosts at the end of the step, which they must outlive; they move straight, with their velocities
  /// \param start, end poses of the solids at the start and the end of the step
  void detect(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
              const Ghosts& ghosts, const std::vector<Solid>& solids,
              const std::vector<Eigen::Isometry3d>& start, const std::vector<Eigen::Isometry3d>& end,
              float dt);

  /// Contacts of particles that u leads elsewhere than the guess, or far: with solids that they end in, and
  /// with the skin there or where they went through it; over such a way it is no plane any more. \return
  /// whether there are any
  bool detectStrays(const Particles& particles, const VectorField& u, float dt);

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

  struct Changes {
    bool any = false;     // whether any contact acts otherwise from now on
    double pulled = 0.0;  // J, work of contacts with solids that pulled particles onto these, and open now
  };
  /// Reads the contact forces off the residual r = (forces - M a) on the particles, N, and changes states: a
  /// contact that pulls opens; one outside the Coulomb cone slides, one inside sticks.
  Changes update(const Particles& particles, const VectorField& u, const VectorField& residual);

  /// Pushes out what still penetrates, and adds the force of doing so. What gets out of one solid into
  /// another stops where its way meets the first.
  void expel(const Particles& particles, VectorField& u, float dt);

  /// Where hands squeeze clay between them, or on solids, no side's plane leads out of all: moves what is
  /// still held, or beneath the skin, to the nearest place that nothing covers.
  void release(const Particles& particles, VectorField& u, float dt);

  /// In this step, by `release`: ghosts that were looked at.
  std::uint64_t looks() const { return looks_; }

  /// Takes from the displacements w, which follow u, what goes into obstacles.
  void stop(const Particles& particles, const VectorField& u, VectorField& w) const;

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
    float pulled = 0.0f;        // J, see Changes
    Eigen::Matrix3f free;       // projector onto the free directions
  };
  void open(Contact& found, const Particles& particles, float dt) const;
  void listFilters();
  void recall(const VectorField& guess, std::size_t first, std::size_t last);
  Contact* known(const Contact& found);
  /// Calls f(filter) for the filters of particles [first, last).
  template <typename F>
  void forFilters(std::size_t first, std::size_t last, const F& f) const;
  float friction(const Contact& c, const Particles& particles) const;
  float adhesion(const Contact& c, const Particles& particles) const;
  float leastStiffness(const Contact& c, const Particles& particles, float dt) const;
  void expel(const Filter& filter, float inertia, Eigen::Vector3f& u);
  static void push(Contact& c, const Eigen::Vector3f& by, float inertia, Eigen::Vector3f& u);
  bool isCovered(const Filter& filter, const Eigen::Vector3f& x, float clearance) const;
  bool isHeld(const Filter& filter, const Eigen::Vector3f& x, const Eigen::Vector3f& step) const;
  std::optional<Eigen::Vector3f> wayOut(const Eigen::Vector3f& x, std::int64_t& looks) const;
  Eigen::Vector3f prescribed(Filter& filter, Eigen::Vector3f u);
  Eigen::Vector3f pull(const Contact& c, const Eigen::Vector3f& u) const;

  float spacing_;
  std::vector<float> friction_, skin_friction_;  // of each material
  std::vector<float> adhesion_;                  // N, of one particle of each material
  Obstacles obstacles_;
  ContactSearch search_;
  std::vector<Contact> contacts_, previous_;
  std::vector<GhostShare> shares_;
  std::vector<Filter> filters_;  // one a touched particle
  std::uint64_t looks_ = 0;
};

}  // namespace tactile_clay::clay
