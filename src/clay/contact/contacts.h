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
/// 1998). The residual in this direction is the force of the contact, the sum of Eq. 6. Friction is a sliding
/// anchor: a tangential spring pulls the particle to its anchor. When the force of the spring leaves the
/// Coulomb cone, the particle slides under mu times the normal force. It then drags the anchor along, at the
/// distance at which the spring has this force. The stiffness of the spring follows the load, so that this
/// distance is a hundredth of a spacing.
class Contacts {
 public:
  /// Maximum number of samples that `release` looks at in a step, for all particles together; only the last
  /// look of each particle may exceed it. This takes some 0.2 s. Hands that knead at the pace of the shipped
  /// scenes need no looks.
  static constexpr std::int64_t max_looks = 20'000'000;

  /// @param spacing m
  /// @param materials they give friction and adhesion
  Contacts(float spacing, const std::vector<Material>& materials);

  /// All contacts, in the order of their particles.
  const std::vector<Contact>& contacts() const { return contacts_; }
  const std::vector<SampleShare>& shares() const { return shares_; }
  /// Takes over contacts as they were after a step; the next step starts from them.
  void restore(std::vector<Contact> contacts) { contacts_ = std::move(contacts); }

  // Search, and the state that is kept from step to step: contacts.cpp.

  /// Starts a step: finds the contacts that may close in it, and recalls the state of those that were closed
  /// before.
  /// @param guess displacements of the particles without internal and contact forces, m
  /// @param around must outlive the step
  void detect(const Neighbourhood& near, const Particles& particles, const VectorField& guess,
              const Surroundings& around);

  /// Adds contacts of particles that u moves far, or to another place than the guess: with solids in which
  /// they end, and with the skin where they end or went through it. Over such a way the skin is no plane any
  /// more, so normals and gaps of known skin contacts change.
  /// @return whether any contact was added or changed
  bool detectStrays(const Particles& particles, const VectorField& u, float dt);

  /// Stores in contacts what solids add to the density of their particles in this step, for the next step.
  void remember(const std::vector<BoundaryDensity::Share>& shares);

  /// Ends a step: sets anchors and stiffnesses for the next one.
  void finish(const Particles& particles, float dt);

  // Contacts in the iterations: contact_forces.cpp.

  /// Closes open contacts that u violates, and moves particles to where their closed contacts prescribe.
  void prescribe(VectorField& u);
  /// Closes contacts, given by their indices.
  void close(const std::vector<std::uint32_t>& which);

  /// Until the next `update`, contacts that slide are damped: their friction is opposite and proportional to
  /// the slip, and has its present value at the slip of u. Such friction takes energy whatever the slip
  /// becomes.
  void dampSlides(const Particles& particles, const VectorField& u, float dt);

  // The next three work on the particles [first, last).
  /// Removes the prescribed directions from a field.
  void filter(std::size_t first, std::size_t last, VectorField& field) const;
  /// Adds the friction at the displacements u to the forces, N.
  void addFriction(const VectorField& u, std::size_t first, std::size_t last, VectorField& force) const;
  /// Adds the change of friction with the displacements p to the forces.
  void addFrictionChange(const VectorField& p, std::size_t first, std::size_t last, VectorField& force) const;

  /// Lists the particles that closed contacts hold, in ascending order.
  void listHeld(std::vector<std::uint32_t>& particles) const;

  struct Changes {
    bool any = false;     // whether any contact acts differently from now on
    double pulled = 0.0;  // J, work of contacts that pulled particles onto solids, and are open now
  };
  /// Reads the contact forces off the residual r = (forces - M a) on the particles, N, and changes states. A
  /// contact that pulls opens. A contact outside the Coulomb cone slides, a contact inside it sticks.
  Changes update(const Particles& particles, const VectorField& u, const VectorField& residual);

  /// Makes the contact forces on each lump add up to `total`, N. The contacts of a lump share the lacking
  /// force in proportion to their forces.
  void balance(const Neighbourhood& near, std::vector<Eigen::Vector3d> total);

  // Removal of penetrations after the iterations: making_room.cpp.

  /// Pushes out particles that still penetrate, and adds the force of this push. A particle that is pushed
  /// out of one solid into another stops at the first one that its way meets.
  void expel(const Particles& particles, VectorField& u, float dt);

  /// Moves particles that are still held, or beneath the skin, to the nearest place that nothing covers. If
  /// hands squeeze clay between them or onto solids, the plane of no side leads out of all of them.
  void release(const Particles& particles, VectorField& u, float dt);

  /// Number of samples that `release` looked at in this step.
  std::uint64_t looks() const { return looks_; }

  /// Removes from the displacements w, which follow u, the parts that lead into colliders.
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
  /// Calls f(filter) for the filters of particles [first, last).
  template <typename F>
  void forFilters(std::size_t first, std::size_t last, const F& f) const {
    auto at = std::lower_bound(filters_.begin(), filters_.end(), first,
                               [](const Filter& a, std::size_t particle) { return a.particle < particle; });
    for (; at != filters_.end() && at->particle < last; ++at) f(*at);
  }
  /// Runs f(k) for k in [0, n), filters or particles, a few at a time.
  template <typename F>
  static void forEach(std::size_t n, const F& f) {
    constexpr std::size_t grain = 64;  // small enough for equal work of threads, large enough to pay
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
  std::vector<Filter> filters_;  // one per touched particle
  std::uint64_t looks_ = 0;
};

/// Force of the spring to the anchor of a contact at the displacement u of its particle, N.
Eigen::Vector3f springPull(const Contact& c, const Eigen::Vector3f& u);
/// Friction of a contact at the displacement u of its particle, N.
Eigen::Vector3f frictionOn(const Contact& c, const Eigen::Vector3f& u);

}  // namespace tactile_clay::clay
