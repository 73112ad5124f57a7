#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "clay/contact/colliders.h"
#include "clay/contact/contact.h"
#include "clay/contact/contact_search.h"
#include "clay/forces/boundary_density.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "clay/threads.h"

namespace tactile_clay::clay {

/// Impenetrability and Coulomb friction against skin samples and solids (paper, section III-D).
///
/// Impenetrability prescribes the displacement along the normal ("filtered" directions, Baraff & Witkin
/// 1998): the residual there is the force of the contact, the sum of Eq. 6. Friction is a sliding anchor: a
/// tangential spring holds the particle at its anchor; once its force leaves the Coulomb cone, the particle
/// slides under mu times the normal force and drags the anchor along, at the distance that this force gives.
/// The spring is as stiff as the load asks, so that this distance is a hundredth of a spacing.
class Contacts {
 public:
  /// Samples that `release` looks at in a step, for all particles together and but for the last look of each:
  /// some 0.2 s. Hands that knead at the shipped scenes' pace need none of it.
  static constexpr std::int64_t max_looks = 20'000'000;

  /// @param materials friction is theirs;
  /// @param spacing m
  Contacts(float spacing, const std::vector<Material>& materials);

  /// In the order of their particles.
  const std::vector<Contact>& contacts() const { return contacts_; }
  const std::vector<SampleShare>& shares() const { return shares_; }
  /// Takes over contacts as they were after a step; the next one starts from them.
  void restore(std::vector<Contact> contacts) { contacts_ = std::move(contacts); }

  // What touches, and what is kept of it from step to step: contacts.cpp.

  /// Starts a step: finds what may touch in it and recalls the state of what touched before.
  /// @param guess displacements, m, that the particles would make freely
  /// @param around must stay for the step
  void detect(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
              const Surroundings& around);

  /// Contacts of particles that u leads elsewhere than the guess, or far: with solids that they end in, and
  /// with the skin there or where they went through it; over such a way it is no plane any more.
  /// @return whether there are any
  bool detectStrays(const Particles& particles, const VectorField& u, float dt);

  /// What solids add to the density of particles in this step, for their contacts to keep in the next.
  void remember(const std::vector<BoundaryDensity::Share>& shares);

  /// Ends a step: slides anchors.
  void finish(const Particles& particles, float dt);

  // What they do in the iterations: contact_forces.cpp.

  /// Closes open contacts that u violates, and moves particles to where their closed contacts prescribe.
  void prescribe(VectorField& u);
  /// Closes some, by their indices.
  void close(const std::vector<std::uint32_t>& which);

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

  struct Changes {
    bool any = false;     // whether any contact acts otherwise from now on
    double pulled = 0.0;  // J, work of contacts with solids that pulled particles onto these, and open now
  };
  /// Reads the contact forces off the residual r = (forces - M a) on the particles, N, and changes states: a
  /// contact that pulls opens; one outside the Coulomb cone slides, one inside sticks.
  Changes update(const Particles& particles, const VectorField& u, const VectorField& residual);

  /// Makes the forces on each lump add up to a total, N. What is lacking, its contacts bear by their shares.
  void balance(const Neighbourhood& near, std::vector<Eigen::Vector3d> total);

  // Making room for what is in the way after them: making_room.cpp.

  /// Pushes out what still penetrates, and adds the force of doing so. What gets out of one solid into
  /// another stops where its way meets the first.
  void expel(const Particles& particles, VectorField& u, float dt);

  /// Where hands squeeze clay between them, or on solids, no side's plane leads out of all: moves what is
  /// still held, or beneath the skin, to the nearest place that nothing covers.
  void release(const Particles& particles, VectorField& u, float dt);

  /// In this step, by `release`: samples that were looked at.
  std::uint64_t looks() const { return looks_; }

  /// Takes from the displacements w, which follow u, what goes into colliders.
  void stop(const Particles& particles, const VectorField& u, VectorField& w) const;

 private:
  struct Filter {  // of a touched particle
    std::uint32_t particle;
    std::uint32_t first, last;  // contacts [first, last) of the particle
    int rank = 0;               // prescribed directions
    float pulled = 0.0f;        // J, see Changes
    Eigen::Matrix3f free;       // projector onto the free directions
  };
  template <typename C>
  struct Range {
    C *first, *last;
    C* begin() const { return first; }
    C* end() const { return last; }
  };
  Range<Contact> of(const Filter& f) { return {contacts_.data() + f.first, contacts_.data() + f.last}; }
  Range<const Contact> of(const Filter& f) const {
    return {contacts_.data() + f.first, contacts_.data() + f.last};
  }
  /// Calls f(filter) for those of particles [first, last).
  template <typename F>
  void forFilters(std::size_t first, std::size_t last, const F& f) const {
    auto at = std::lower_bound(filters_.begin(), filters_.end(), first,
                               [](const Filter& a, std::size_t particle) { return a.particle < particle; });
    for (; at != filters_.end() && at->particle < last; ++at) f(*at);
  }
  /// Runs f(k) for k in [0, n), filters or particles, a few at a time.
  template <typename F>
  static void forEach(std::size_t n, const F& f) {
    constexpr std::size_t grain = 64;  // few enough that threads get equal work, many enough that it pays
    parallelFor(n, grain, f);
  }

  Contact opened(const ContactGeometry& found, const Particles& particles, float dt) const;
  void recall(const VectorField& guess, std::size_t first, std::size_t last);
  Contact* known(const ContactGeometry& found);
  void listFilters();
  float friction(const Contact& c, const Particles& particles) const;
  float adhesion(const Contact& c, const Particles& particles) const;

  Eigen::Vector3f prescribed(Filter& filter, Eigen::Vector3f u);
  bool update(Contact& c, const Particles& particles, const Eigen::Vector3f& u, float pressing, float load);

  void expel(const Filter& filter, float inertia, Eigen::Vector3f& u);
  static void push(Contact& c, const Eigen::Vector3f& by, float inertia, Eigen::Vector3f& u);
  std::vector<std::uint32_t> held(const Particles& particles, const VectorField& u) const;
  bool isHeld(const Filter& filter, const Eigen::Vector3f& x, const Eigen::Vector3f& step) const;
  bool isCovered(const Filter& filter, const Eigen::Vector3f& x, float clearance) const;
  std::optional<Eigen::Vector3f> wayOut(const Eigen::Vector3f& x, std::int64_t& looks) const;

  float spacing_;
  std::vector<float> friction_, skin_friction_;  // of each material
  std::vector<float> adhesion_;                  // N, of one particle of each material
  Colliders colliders_;
  ContactSearch search_;
  std::vector<Contact> contacts_, previous_;
  std::vector<SampleShare> shares_;
  std::vector<Filter> filters_;  // one a touched particle
  std::uint64_t looks_ = 0;
};

/// Force of the spring to the anchor of a contact at the displacement u of its particle, N.
Eigen::Vector3f springPull(const Contact& c, const Eigen::Vector3f& u);
/// Friction of a contact there, N.
Eigen::Vector3f frictionOn(const Contact& c, const Eigen::Vector3f& u);

}  // namespace tactile_clay::clay
